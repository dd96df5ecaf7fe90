"""The flexible hinge: stress resultants of the drive (1) and the two bendings (2, 3)."""

from sympy import Abs, Max, Min, Symbol, cos, sin

from flexmodels.effects.dahl import dahl
from flexmodels.effects.effect import Coverage, Effect, Parameter
from flexmodels.effects.signals import deps, e, eps

_k = {i: Parameter(f"k[{i}]", "N.m/rad", lower=0) for i in eps}
_d = {i: Parameter(f"d[{i}]", "N.m.s/rad", lower=0) for i in eps}


def _each(coefficients: dict[int, Parameter], rates: dict[int, Symbol]):
    return {eps[i]: coefficients[i].symbol * rates[i] for i in eps}


stiffness = Effect(
    name="stiffness",
    title="Stiffness of the drive and of the bearings",
    forces=_each(_k, eps),
    parameters=tuple(_k.values()),
    citation="Hardeman, Aarts and Jonker, eq. (4); Spong 1987",
    base=True,
    needs="excitation of the deformations",
    confounders=("hardening_stiffness", "backlash", "joint_spring"),
    experiment="a multisine up to the resonances",
)

damping = Effect(
    name="damping",
    title="Structural damping of the drive and of the bearings",
    forces=_each(_d, deps),
    parameters=tuple(_d.values()),
    citation="Hardeman, Aarts and Jonker, eq. (4)",
    base=True,
    needs="excitation near the resonances",
    confounders=("transmission_hysteresis",),
    experiment="a multisine up to the resonances",
)

_cubic = Parameter("cubic", "N.m/rad3", lower=0)

hardening_stiffness = Effect(
    name="hardening_stiffness",
    title="Stiffness of the drive that grows with its deformation: the cubic part",
    forces={eps[1]: _cubic.symbol * eps[1] ** 3},
    parameters=(_cubic,),
    citation="Tuttle and Seering 1996; Kircanski and Goldenberg 1997",
    needs="deformations from small to the rated torque's",
    confounders=("k[1]", "backlash"),
    experiment="static loads or slow multisines of two amplitudes or more",
)

_stiffness = Parameter("stiffness", "N.m/rad", lower=0, usual=0.9 * _k[1].symbol)
_gap = Parameter("gap", "rad", start=1e-4, lower=0, grid=(0.1, 0.2, 0.4, 0.8), scale=eps[1])

backlash = Effect(
    name="backlash",
    title="Backlash: stiffness that the drive lacks in a gap to either side, half of the play",
    forces={eps[1]: -_stiffness.symbol * Max(-_gap.symbol, Min(eps[1], _gap.symbol))},
    parameters=(_stiffness, _gap),
    proper=_stiffness.symbol > _k[1].symbol / 2,
    sized_by="gap",
    citation="Nordin and Gutman 2002; Ruderman, Hoffmann and Bertram 2009",
    needs="torque reversals of the drive: 5 % of the samples within the gap",
    coverage=Coverage(Abs(eps[1]) < _gap.symbol, 0.05),
    confounders=("k[1]", "hardening_stiffness", "transmission_hysteresis", "presliding"),
    experiment="small oscillations about a pose in which the joint carries no load",
)

_level = Parameter("level", "N.m", lower=0)
_travel = Parameter("travel", "rad", start=1e-4, lower=1e-8, grid=(0.1, 0.3, 1.0, 3.0), scale=eps[1])
_strain = dahl("strain", deps[1], _travel)

transmission_hysteresis = Effect(
    name="transmission_hysteresis",
    title="Hysteresis of the drive: dry friction that builds up with its deformation (Dahl)",
    forces={eps[1]: _level.symbol * _strain.symbol},
    parameters=(_level, _travel),
    states=(_strain,),
    citation="Dahl 1968; Ruderman, Hoffmann and Bertram 2009",
    needs="many reversals of the drive's torque, of several amplitudes",
    confounders=("d[1]", "k[1]", "backlash", "presliding"),
    experiment="slow torque cycles of growing amplitude with the link held or heavy",
)

_k12, _k13, _k23 = (Parameter(name, "N.m/rad") for name in ("k12", "k13", "k23"))

stiffness_coupling = Effect(
    name="stiffness_coupling",
    title="Coupling of the drive's deformation with the bendings, and of the bendings with each other",
    forces={
        eps[1]: _k12.symbol * eps[2] + _k13.symbol * eps[3],
        eps[2]: _k12.symbol * eps[1] + _k23.symbol * eps[3],
        eps[3]: _k13.symbol * eps[1] + _k23.symbol * eps[2],
    },
    parameters=(_k12, _k13, _k23),
    citation="Moberg, Wernholt, Hanssen and Brogårdh 2014",
    needs="independent excitation of all three deformations",
    confounders=("k[1]", "k[2]", "k[3]", "J[xy]", "J[xz]", "J[yz]"),
    experiment="multisines at every joint, in poses that load the bearings differently",
)

# With an error delta(e) of the transmission the link stands at e + delta without load, so the spring is
# turned by eps1 - delta and stores k1 (eps1 - delta)²/2. To first order in delta this is k1 eps1²/2 + V with
# V = -k1 delta eps1 = eps1 (cosine cos(n e) + sine sin(n e)), where cosine and sine are the amplitudes of
# the error times -k1. The forces are dV/d(eps1) and dV/de: they do no work over a cycle.
_cosine, _sine = Parameter("cosine", "N.m"), Parameter("sine", "N.m")
_orders = tuple(float(order) for order in range(4, 31, 2))  # periods per turn of the joint
_order = Parameter("order", "1", start=4.0, lower=3.0, grid=_orders, periodic=True)
_phase = _order.symbol * e
_in_phase = _cosine.symbol * cos(_phase) + _sine.symbol * sin(_phase)
_in_quadrature = _sine.symbol * cos(_phase) - _cosine.symbol * sin(_phase)

kinematic_error = Effect(
    name="kinematic_error",
    title="Periodic error of the gear's transmission, times the stiffness of the drive",
    forces={eps[1]: _in_phase, e: _order.symbol * eps[1] * _in_quadrature},
    parameters=(_cosine, _sine, _order),
    citation="Tuttle and Seering 1996; Ghorbel, Gandhi and Alpeter 2001",
    needs="a period of the error, passed at several speeds",
    confounders=("torque_ripple", "ms[x]", "ms[y]", "ms[z]"),
    experiment="slow constant speed over the whole range with the link's position measured",
)

# Encoders of motor and link that read z apart without load leave a spring k1 (eps1 - z)²/2 in what they read.
_torque = Parameter("torque", "N.m")

twist_offset = Effect(
    name="twist_offset",
    title="Zero of the drive's deformation as it is measured: minus its stiffness times that deformation",
    forces={eps[1]: _torque.symbol},
    parameters=(_torque,),
    citation="Tuttle and Seering 1996: the part of the transmission's error without a period",
    needs="poses that load the drive differently",
    confounders=("backlash", "offset", "joint_spring", "gravity_spring", "ms[x]", "ms[y]", "ms[z]"),
    experiment="slow motion through poses in which gravity loads the drive in both directions",
)
