  type Position = Real(final quantity="Length", final unit="m");
  type Angle = Real(final quantity="Angle", final unit="rad");
  type AngularVelocity = Real(final quantity="AngularVelocity", final unit="rad/s");
  type AngularAcceleration = Real(final quantity="AngularAcceleration", final unit="rad/s2");
  type Acceleration = Real(final quantity="Acceleration", final unit="m/s2");
  type Force = Real(final quantity="Force", final unit="N");
  type Torque = Real(final quantity="Torque", final unit="N.m");
  type Inertia = Real(final quantity="MomentOfInertia", final unit="kg.m2");
  type Mass = Real(final quantity="Mass", final unit="kg", min=0);
  type Time = Real(final quantity="Time", final unit="s");

  connector Outward "Behind a hinge: axes of the body and its motion, all in base axes"
    output Position r[3] "Origin";
    output Real A[3, 3] "Columns: the body's axes";
    output AngularVelocity omega[3] "Angular velocity";
    output Acceleration a[3] "Acceleration of the origin, less that of gravity";
    output AngularAcceleration alpha[3] "Angular acceleration";
    input Force f[3] "Force that what hangs here needs";
    input Torque t[3] "Torque that it needs about the origin";
  end Outward;

  connector Inward "The same, from the other side"
    input Position r[3] "Origin";
    input Real A[3, 3] "Columns: the body's axes";
    input AngularVelocity omega[3] "Angular velocity";
    input Acceleration a[3] "Acceleration of the origin, less that of gravity";
    input AngularAcceleration alpha[3] "Angular acceleration";
    output Force f[3] "Force that what hangs here needs";
    output Torque t[3] "Torque that it needs about the origin";
  end Inward;

  model Base "Where the arm stands"
    parameter Acceleration gravity[3];
    Outward out;
  equation
    out.r = zeros(3);
    out.A = identity(3);
    out.omega = zeros(3);
    out.a = -gravity;
    out.alpha = zeros(3);
  end Base;

  model Friction "Coulomb and viscous friction that sticks, and the offset of the torque"
    parameter Real coulomb(min=0) "c^(c)";
    parameter Real viscous(min=0) "c^(v)";
    parameter Real offset = 0;
    Real de(start=0) "Speed";
    Real dde "Its rate";
    Real torque "What friction takes; the reaction while the hinge is stuck";
    discrete Integer mode(start=0, fixed=true) "1: slides forward, -1: backward, 0: stuck";
  equation
    0 = if mode == 0 then dde else torque - (mode*coulomb + viscous*de + offset);
    when {pre(mode) == 0 and torque - offset > coulomb,
          pre(mode) == 0 and torque - offset < -coulomb,
          pre(mode) == 1 and de < 0,
          pre(mode) == -1 and de > 0} then
      mode = if pre(mode) <> 0 then 0 elseif torque > offset then 1 else -1;
    end when;
  end Friction;

  model MotorHinge "Motor with friction that turns what hangs behind it about x"
    parameter Real x[3] "Axis in the parent's axes";
    parameter Position origin[3] "From the parent's origin, in its axes";
    parameter Inertia J_m "J^(m)";
    parameter Real coulomb(min=0) "c^(c)";
    parameter Real viscous(min=0) "c^(v)";
    parameter Real offset = 0;
    parameter Angle e_start = 0;
    Inward inn;
    Outward out;
    Friction friction(coulomb=coulomb, viscous=viscous, offset=offset);
    Angle e(start=e_start, fixed=true) "e^(m)";
    AngularVelocity de(start=0, fixed=true);
    AngularAcceleration dde;
    Torque tau "Of the motor";
  protected
    Real axis[3] "In base axes";
    Position arm[3] "To the hinge, in base axes";
  equation
    der(e) = de;
    der(de) = dde;
    friction.de = de;
    friction.dde = dde;
    axis = inn.A*x;
    arm = inn.A*origin;
    out.r = inn.r + arm;
    out.A = inn.A*rotation(x, e);
    out.omega = inn.omega + axis*de;
    out.a = inn.a + cross3(inn.alpha, arm) + cross3(inn.omega, cross3(inn.omega, arm));
    out.alpha = inn.alpha + axis*dde + cross3(inn.omega, axis)*de;
    inn.f = out.f;
    inn.t = out.t + cross3(arm, out.f);
    tau = J_m*dde + friction.torque + axis*out.t;
    when {friction.mode == 0} then
      reinit(de, 0);
    end when;
  end MotorHinge;

  model FlexibleHinge "Bends, then twists: x' goes to n by the shortest rotation, then eps[1] about n"
    parameter Real triad[3, 3] "Columns: x', y', z' in the parent's axes";
    parameter Real k[3] "Stiffness";
    parameter Real d[3] "Damping";
    parameter Angle eps_start[3] = zeros(3);
    Inward inn;
    Outward out;
    Angle eps[3](start=eps_start, each fixed=true) "Twist, and bending towards y' and z'";
    AngularVelocity deps[3](each start=0, each fixed=true);
    AngularAcceleration ddeps[3];
  protected
    Real c "Cosine of the bending angle";
    Real dc;
    Real ddc;
    Real n[3] "The axis that was x', in the triad";
    Real dn[3];
    Real ddn[3];
    Real s "First component of n x dn: what the shortest rotation turns about n";
    Real ds;
    Real omega[3] "Relative angular velocity, in the triad";
    Real alpha[3] "Its rate";
    Real T[3, 3] "The triad in base axes";
    Real t[3] "Torque of what hangs behind, in the triad";
    Real across2[3] "n x dn/deps[2]";
    Real across3[3] "n x dn/deps[3]";
  equation
    der(eps) = deps;
    der(deps) = ddeps;
    c = sqrt(1 - eps[2]^2 - eps[3]^2);
    dc = -(eps[2]*deps[2] + eps[3]*deps[3])/c;
    ddc = -(deps[2]^2 + deps[3]^2 + eps[2]*ddeps[2] + eps[3]*ddeps[3] + dc^2)/c;
    n = {c, eps[2], eps[3]};
    dn = {dc, deps[2], deps[3]};
    ddn = {ddc, ddeps[2], ddeps[3]};
    s = n[2]*dn[3] - n[3]*dn[2];
    ds = n[2]*ddn[3] - n[3]*ddn[2];
    omega = cross3(n, dn) - n*s/(1 + c) + n*deps[1];
    alpha = cross3(n, ddn) - dn*s/(1 + c) - n*(ds/(1 + c) - s*dc/(1 + c)^2) + n*ddeps[1] + dn*deps[1];
    T = inn.A*triad;
    out.r = inn.r;
    out.A = T*bent(eps)*transpose(triad);
    out.omega = inn.omega + T*omega;
    out.a = inn.a;
    out.alpha = inn.alpha + T*alpha + cross3(inn.omega, T*omega);
    inn.f = out.f;
    inn.t = out.t;
    t = transpose(T)*out.t;
    across2 = cross3(n, {-eps[2]/c, 1, 0});
    across3 = cross3(n, {-eps[3]/c, 0, 1});
    0 = k[1]*eps[1] + d[1]*deps[1] + n*t;
    0 = k[2]*eps[2] + d[2]*deps[2] + (across2 - n*across2[1]/(1 + c))*t;
    0 = k[3]*eps[3] + d[3]*deps[3] + (across3 - n*across3[1]/(1 + c))*t;
  end FlexibleHinge;

  model TwistHinge "Flexible hinge that twists about x only"
    parameter Real x[3] "Axis in the parent's axes";
    parameter Real k "Stiffness";
    parameter Real d "Damping";
    parameter Angle eps_start = 0;
    Inward inn;
    Outward out;
    Angle eps(start=eps_start, fixed=true);
    AngularVelocity deps(start=0, fixed=true);
    AngularAcceleration ddeps;
  protected
    Real axis[3] "In base axes";
  equation
    der(eps) = deps;
    der(deps) = ddeps;
    axis = inn.A*x;
    out.r = inn.r;
    out.A = inn.A*rotation(x, eps);
    out.omega = inn.omega + axis*deps;
    out.a = inn.a;
    out.alpha = inn.alpha + axis*ddeps + cross3(inn.omega, axis)*deps;
    inn.f = out.f;
    inn.t = out.t;
    0 = k*eps + d*deps + axis*out.t;
  end TwistHinge;

  model Link "Rigid body lumped at its joint, eq. (1)"
    parameter Mass m;
    parameter Real ms[3] "First moments about the joint [kg m]";
    parameter Inertia J[3, 3] "About the joint";
    parameter Position reach[3] "To the end that is shown, in the link's axes";
    Inward inn;
    Position tip[3] "The end in base axes";
  protected
    Real w[3] "Angular velocity in the link's axes";
    Real z[3] "Angular acceleration";
    Real b[3] "Acceleration of the joint, less gravity's";
  equation
    w = transpose(inn.A)*inn.omega;
    z = transpose(inn.A)*inn.alpha;
    b = transpose(inn.A)*inn.a;
    tip = inn.r + inn.A*reach;
    inn.f = inn.A*(m*b + cross3(z, ms) + cross3(w, cross3(w, ms)));
    inn.t = inn.A*(J*z + cross3(w, J*w) + cross3(ms, b));
  end Link;

  model Pid "Digital PID controller with held torque, sampled every `period`"
    parameter Time period;
    parameter Real Kp;
    parameter Real Kd;
    parameter Real Ki;
    parameter Real integral_start = 0 "Torque that holds the arm at its start";
    input Real r "Reference";
    input Real tau_ff "Added torque";
    input Real e "Measured";
    discrete output Real tau(start=0, fixed=true);
    discrete Real error(start=0, fixed=true);
    discrete Real integral(start=integral_start, fixed=true);
    discrete Integer ticks(start=0, fixed=true);
  equation
    when sample(0, period) then
      error = r - e;
      ticks = pre(ticks) + 1;
      integral = pre(integral) + (if pre(ticks) == 0 then 0 else Ki*period*error);
      tau = Kp*error + (if pre(ticks) == 0 then 0 else Kd*(error - pre(error))/period) + integral + tau_ff;
    end when;
  end Pid;

  function cross3 "Vector product"
    input Real u[3];
    input Real v[3];
    output Real w[3];
  algorithm
    w := {u[2]*v[3] - u[3]*v[2], u[3]*v[1] - u[1]*v[3], u[1]*v[2] - u[2]*v[1]};
  end cross3;

  function rotation "By an angle about a unit vector"
    input Real x[3];
    input Real angle;
    output Real R[3, 3];
  protected
    Real c;
    Real s;
  algorithm
    c := cos(angle);
    s := sin(angle);
    R := {{c + (1 - c)*x[1]^2, (1 - c)*x[1]*x[2] - s*x[3], (1 - c)*x[1]*x[3] + s*x[2]},
          {(1 - c)*x[1]*x[2] + s*x[3], c + (1 - c)*x[2]^2, (1 - c)*x[2]*x[3] - s*x[1]},
          {(1 - c)*x[1]*x[3] - s*x[2], (1 - c)*x[2]*x[3] + s*x[1], c + (1 - c)*x[3]^2}};
  end rotation;

  function bent "x' to (c, eps[2], eps[3]) by the shortest rotation, after a twist by eps[1]"
    input Real eps[3];
    output Real R[3, 3];
  protected
    Real c;
    Real h;
    Real p;
    Real q;
  algorithm
    c := sqrt(1 - eps[2]^2 - eps[3]^2);
    h := -eps[2]*eps[3]/(1 + c);
    p := cos(eps[1]);
    q := sin(eps[1]);
    R := {{c, -eps[2]*p - eps[3]*q, eps[2]*q - eps[3]*p},
          {eps[2], (1 - eps[2]^2/(1 + c))*p + h*q, -(1 - eps[2]^2/(1 + c))*q + h*p},
          {eps[3], h*p + (1 - eps[3]^2/(1 + c))*q, -h*q + (1 - eps[3]^2/(1 + c))*p}};
  end bent;
