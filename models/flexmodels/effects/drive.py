"""The motor's own laws."""

from sympy import Abs, Max, Symbol, cos, sign, sin

from flexmodels.effects.effect import Coverage, Effect, Parameter, State
from flexmodels.effects.settling import elapsed, slow_settling
from flexmodels.effects.signals import dde, e, period, tau

_J_m = Parameter("J_m", "kg.m2", lower=0)

motor_inertia = Effect(
    name="motor_inertia",
    title="Rotor and gear inertia, seen at the joint",
    forces={e: _J_m.symbol * dde},
    parameters=(_J_m,),
    citation="Hardeman, Aarts and Jonker, eq. (2)",
    base=True,
    needs="accelerations",
    confounders=("J[xx]", "J[yy]", "J[zz]"),
    experiment="a multisine above the first resonance, where the links stand still",
)

_cosine, _sine = Parameter("cosine", "N.m"), Parameter("sine", "N.m")
_orders = tuple(float(order) for order in range(4, 31, 2))  # periods per turn of the joint
_order = Parameter("order", "1", start=4.0, lower=3.0, grid=_orders, periodic=True)

torque_ripple = Effect(
    name="torque_ripple",
    title="Torque that the motor lacks periodically: cogging and commutation",
    forces={e: _cosine.symbol * cos(_order.symbol * e) + _sine.symbol * sin(_order.symbol * e)},
    parameters=(_cosine, _sine, _order),
    citation="Jahns and Soong 1996",
    needs="a period of the ripple, passed in both directions",
    confounders=("kinematic_error", "offset", "gravity_spring", "ms[x]", "ms[y]", "ms[z]"),
    experiment="slow constant speed over the whole range, forward and backward",
)

_share = Parameter("share", "1", start=1.0, lower=0)
_delay = Parameter("delay", "s", start=0.002, lower=1e-5, grid=(0.0005, 0.001, 0.002, 0.004, 0.008))
_delivered_now = Symbol("delivered", real=True)
_delivered = State("delivered", (tau - _delivered_now) / _delay.symbol, None, "N.m")

torque_delay = Effect(
    name="torque_delay",
    title="Torque that comes late: a first-order lag of the current loop",
    forces={e: _share.symbol * (tau - _delivered.symbol)},
    parameters=(_share, _delay),
    states=(_delivered,),
    proper=_share.symbol * _delay.symbol > 0.2 * period,  # rows do not tell when in a cycle a drive reads
    citation="Khalil and Dombre 2002; Moberg, Wernholt, Hanssen and Brogårdh 2014",
    needs="torques that change within the delay",
    confounders=("J_m", "viscous", "d[1]"),
    experiment="a multisine torque up to the controller's rate",
)

_excess = Parameter("share", "1", lower=0, upper=1)
_limit = Parameter("limit", "N.m", start=1000.0, lower=0, grid=(1.25, 1.5, 2.0, 2.5), scale=tau)

torque_saturation = Effect(
    name="torque_saturation",
    title="Torque beyond a limit of which the motor delivers only a part: a share of 1 is a hard limit",
    forces={e: _excess.symbol * sign(tau) * Max(Abs(tau) - _limit.symbol, 0)},
    parameters=(_excess, _limit),
    citation="Hollerbach, Khalil and Gautier 2016",
    needs="torques beyond the limit in 2 % of the samples",
    coverage=Coverage(Abs(tau) > _limit.symbol, 0.02),
    confounders=("torque_droop", "load_dependent_friction", "J_m"),
    experiment="the same motion at full and at half the speed",
)

_fall = Parameter("fall", "1/(N.m)", lower=0)

torque_droop = Effect(
    name="torque_droop",
    title="Torque constant that falls in proportion to the current, as where iron saturates",
    forces={e: _fall.symbol * Abs(tau) * tau},
    parameters=(_fall,),
    citation="Hendershot and Miller 2010",
    needs="torques from small to the drive's peak",
    confounders=("torque_saturation", "quadratic_load_friction", "gravity_spring"),
    experiment="the same motion at full and at half the speed",
)

_rate = Parameter("rate", "N.m/s")

offset_drift = Effect(
    name="offset_drift",
    title="Constant torque that changes over the log and settles, as when an amplifier warms up",
    forces={e: _rate.symbol * elapsed},
    parameters=(_rate, slow_settling),
    citation="Hollerbach, Khalil and Gautier 2016",
    needs="a motion that repeats from the beginning to the end of the log",
    confounders=("offset", "joint_spring", "gravity_spring", "coulomb_drift"),
    experiment="the same motion after a cold and after a warm start",
)
