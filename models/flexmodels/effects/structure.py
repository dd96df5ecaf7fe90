"""Around the joint: springs, cables, mechanical couplings and what the tip carries."""

from sympy import Matrix, Max, Min, cos, eye, pi, sign, sin, sqrt

from flexmodels.effects.effect import Effect, Parameter
from flexmodels.effects.signals import beyond, dde, de, e, eps, tip

_angle = e + eps[1]  # of the link relative to the joint's base side: it loads motor and transmission alike

_stiffness, _pull = Parameter("stiffness", "N.m/rad"), Parameter("preload", "N.m")

joint_spring = Effect(
    name="joint_spring",
    title="Spring between the links on both sides of the joint, as of hoses and cables",
    forces={q: _stiffness.symbol * _angle + _pull.symbol for q in (e, eps[1])},
    parameters=(_stiffness, _pull),
    citation="Hollerbach, Khalil and Gautier 2016",
    needs="a large part of the joint's range",
    confounders=("ms[x]", "ms[y]", "ms[z]", "gravity_spring", "slack_spring", "offset", "twist_offset"),
    experiment="slow motion over the whole range, at an axis that gravity does not load if there is one",
)

_below, _above = (Parameter(f"stiffness_{side}", "N.m/rad", lower=0) for side in ("below", "above"))
_from = Parameter("start_below", "rad", start=-1.0, grid=(0.1, 0.25, 0.4), across=e)
_to = Parameter("start_above", "rad", start=1.0, grid=(0.6, 0.75, 0.9), across=e)
_pulls = _below.symbol * Min(_angle - _from.symbol, 0) + _above.symbol * Max(_angle - _to.symbol, 0)

slack_spring = Effect(
    name="slack_spring",
    title="Hose, cable or stop with slack: a spring that acts below one angle and above another",
    forces={q: _pulls for q in (e, eps[1])},
    parameters=(_below, _above, _from, _to),
    proper=_from.symbol < _to.symbol,
    citation="Nordin and Gutman 2002: the dead zone",
    needs="the ends of the joint's range, where the hose is tight or the stop is touched",
    confounders=("joint_spring", "gravity_spring"),
    experiment="slow motion into both ends of the range",
)

# The spring runs from a pivot on the base side, at distance a from the joint, to one on the link, at
# distance ratio a. It stretches from its free length l0 to a L and stores k (a L - l0)²/2, whose derivative
# by the angle is (k a² - k a l0 / L) ratio sin(angle - phase): stiffness = k a², preload = k a l0.
_k, _preload = Parameter("stiffness", "N.m"), Parameter("preload", "N.m")
_ratio = Parameter("ratio", "1", start=0.5, lower=0.01, upper=0.99, grid=(0.2, 0.4, 0.6, 0.8))
_turns = tuple(float(i * pi / 4) for i in range(-3, 5))
_phase = Parameter("phase", "rad", lower=-float(pi), upper=float(pi), grid=_turns)
_turned = _angle - _phase.symbol
_L = sqrt(1 + _ratio.symbol**2 - 2 * _ratio.symbol * cos(_turned))
_torque = (_k.symbol - _preload.symbol / _L) * _ratio.symbol * sin(_turned)

gravity_spring = Effect(
    name="gravity_spring",
    title="Counterbalance: a spring or gas cylinder between pivots on both sides of the joint",
    forces={q: _torque for q in (e, eps[1])},
    parameters=(_k, _preload, _ratio, _phase),
    turning=True,
    citation="Jubien and Gautier 2013; Arakelian 2016",
    needs="a large part of the joint's range",
    confounders=("ms[x]", "ms[y]", "ms[z]", "joint_spring", "slack_spring", "torque_ripple"),
    experiment="slow motion over the whole range with two payloads, or with the spring taken off",
)

_inertia = Parameter("inertia", "kg.m2", lower=0)
_viscous = Parameter("viscous", "N.m.s/rad", lower=0)
_coulomb = Parameter("coulomb", "N.m", lower=0)
_ratio = Parameter(
    "ratio", "1", start=1.0, lower=-1000.0, upper=1000.0, grid=(1.0, -1.0), between=(de, beyond.de)
)
# A shaft turns with both motors, at speed de + ratio * beyond.de. Of its inertia and viscous friction only
# the mixed terms stand here: the others are part of each motor's own.
_rub = _coulomb.symbol * sign(de + _ratio.symbol * beyond.de)

joint_coupling = Effect(
    name="joint_coupling",
    title="Gears that tie the motor to the next joint's, as in a wrist: shared inertia and friction",
    forces={
        e: _ratio.symbol * (_inertia.symbol * beyond.dde + _viscous.symbol * beyond.de) + _rub,
        beyond.e: _ratio.symbol * (_inertia.symbol * dde + _viscous.symbol * de + _rub),
    },
    parameters=(_inertia, _viscous, _coulomb, _ratio),
    citation="Gautier, Janot and Vandanjon 2013",
    needs="both joints moving, together and against each other",
    confounders=("coulomb", "viscous", "J_m"),
    experiment="each of the two joints alone, then both in the same and in opposite directions",
)

_mass = Parameter("mass", "kg", lower=0)
_moments = tuple(Parameter(f"moment_{axis}", "kg.m") for axis in "xyz")
_inertias = tuple(Parameter(f"inertia_{axes}", "kg.m2") for axes in ("xx", "xy", "xz", "yy", "yz", "zz"))
_m = _mass.symbol
_h = Matrix([moment.symbol for moment in _moments])
_xx, _xy, _xz, _yy, _yz, _zz = (inertia.symbol for inertia in _inertias)
_t = Matrix([tip.x, tip.y, tip.z])
_ms = _h + _m * _t
_J = (  # Steiner, from the tip to the link's origin
    Matrix([[_xx, _xy, _xz], [_xy, _yy, _yz], [_xz, _yz, _zz]])
    + (_m * _t.dot(_t) + 2 * _h.dot(_t)) * eye(3)
    - (_m * _t * _t.T + _h * _t.T + _t * _h.T)
)

payload = Effect(
    name="payload",
    title="Body held at the tip; its moments and inertias are those about the tip",
    forces={},
    body={"m": _m}
    | {f"ms[{x}]": _ms[i] for i, x in enumerate("xyz")}
    | {f"J[{x}{y}]": _J[i, k] for i, x in enumerate("xyz") for k, y in enumerate("xyz") if i <= k},
    parameters=(_mass, *_moments, *_inertias),
    citation="Khalil, Gautier and Lemoine 2007",
    needs="poses in which the tip loads several joints",
    confounders=("m", "ms[x]", "ms[y]", "ms[z]", "J[xx]", "J[yy]", "J[zz]"),
    experiment="the same motion with and without the payload; the links' parameters are kept between them",
)
