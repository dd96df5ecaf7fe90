"""Friction at the motor hinge: torque that opposes its speed."""

from sympy import Abs, And, Or, cos, exp, sign, sin

from flexmodels.effects.dahl import dahl
from flexmodels.effects.effect import SLOW, Coverage, Effect, Parameter
from flexmodels.effects.settling import elapsed, settling
from flexmodels.effects.signals import de, e, load

_coulomb = Parameter("coulomb", "N.m", lower=0)
_viscous = Parameter("viscous", "N.m.s/rad", lower=0)
_offset = Parameter("offset", "N.m")

coulomb = Effect(
    name="coulomb",
    title="Coulomb friction",
    forces={e: _coulomb.symbol * sign(de)},
    parameters=(_coulomb,),
    citation="Hardeman, Aarts and Jonker, eq. (3)",
    base=True,
    needs="both directions",
    confounders=("offset", "viscous"),
    experiment="constant speeds in both directions, at least three levels",
)

viscous = Effect(
    name="viscous",
    title="Viscous friction",
    forces={e: _viscous.symbol * de},
    parameters=(_viscous,),
    citation="Hardeman, Aarts and Jonker, eq. (3)",
    base=True,
    needs="several speeds",
    confounders=("coulomb", "nonlinear_viscous"),
    experiment="constant speeds in both directions, at least three levels",
)

offset = Effect(
    name="offset",
    title="Constant torque: amplifier offset, asymmetric Coulomb level or an unmodelled weight",
    forces={e: _offset.symbol},
    parameters=(_offset,),
    citation="Janot, Gautier and Brunot 2019",
    base=True,
    needs="both directions",
    confounders=("asymmetric_coulomb", "ms[x]", "ms[y]", "ms[z]"),
    experiment="the same path forward and backward",
)

asymmetric_coulomb = Effect(
    name="asymmetric_coulomb",
    title="Friction that differs with the direction: half the difference of the levels and of the slopes",
    forces={e: _coulomb.symbol * Abs(sign(de)) + _viscous.symbol * Abs(de)},
    parameters=(Parameter("coulomb", "N.m"), Parameter("viscous", "N.m.s/rad")),
    citation="Janot, Gautier and Brunot 2019",
    needs="both directions, each at two speeds or more",
    coverage=Coverage(de < 0, 0.1),
    confounders=("offset", "viscous"),
    experiment="constant speeds in both directions, at least three levels",
)

_level = Parameter("level", "N.m", lower=0)
_velocity = Parameter("velocity", "rad/s", start=0.1, lower=1e-4, grid=(0.02, 0.05, 0.1, 0.2, 0.4), scale=de)

stribeck = Effect(
    name="stribeck",
    title="Stribeck friction: what slow motion takes in excess of the Coulomb level",
    forces={e: _level.symbol * sign(de) * exp(-((Abs(de) / _velocity.symbol) ** 2))},
    parameters=(_level, _velocity),
    citation="Armstrong-Hélouvry, Dupont and Canudas de Wit 1994; Bona and Indri 2005",
    needs="slow motion: 5 % of the samples below the Stribeck velocity",
    coverage=Coverage(Abs(de) < _velocity.symbol, 0.05),
    confounders=("coulomb", "viscous", "presliding", "nonlinear_viscous"),
    experiment="constant speeds from creeping to fast, in both directions",
)

_coefficient = Parameter("coefficient", "1", lower=0)

load_dependent_friction = Effect(
    name="load_dependent_friction",
    title="Dry friction that grows with the torque that the transmission carries",
    forces={e: _coefficient.symbol * Abs(load) * sign(de)},
    parameters=(_coefficient,),
    proper=_coefficient.symbol < 2,  # a third of the power arrives; beyond, the torque explains itself
    citation="Hamon, Gautier and Garrec 2010",
    needs="loads that vary as much as they are large, moved in both directions",
    confounders=("coulomb", "viscous", "position_dependent_friction"),
    experiment="the same slow motion with and without a payload",
)

_growth = Parameter("growth", "1/(N.m)", lower=0)

quadratic_load_friction = Effect(
    name="quadratic_load_friction",
    title="Dry friction that grows with the square of the torque that the transmission carries",
    forces={e: _growth.symbol * load**2 * sign(de)},
    parameters=(_growth,),
    excess_over="load_dependent_friction",
    citation="Duclusaud et al. 2024, model M6",
    needs="loads from small to the rated one, moved in both directions",
    confounders=("load_dependent_friction", "coulomb", "torque_saturation"),
    experiment="the same slow motion with several payloads",
)

_travel = Parameter("travel", "rad", start=0.01, lower=1e-5, grid=(0.001, 0.003, 0.01, 0.03))
_bristle = dahl("bristle", de, _travel)

presliding = Effect(
    name="presliding",
    title="Dry friction that builds up over a travel behind each reversal (Dahl), for the Coulomb part",
    forces={e: _level.symbol * (_bristle.symbol - sign(de))},
    parameters=(_level, _travel),
    states=(_bristle,),
    citation="Dahl 1968; Canudas de Wit et al. 1995; Al-Bender, Lampaert and Swevers 2005",
    needs="many reversals, sampled several times within the travel",
    confounders=("coulomb", "stribeck", "transmission_hysteresis", "backlash"),
    experiment="slow reversals of growing amplitude about one pose",
)

_at_one = Parameter("coefficient", "N.m")  # the friction at 1 rad/s
_exponents = (0.3, 0.9, 2.0, 3.0)
_power = Parameter("power", "1", start=2.0, lower=0.2, upper=3.0, grid=_exponents)
# Rounded where the joint turns, where a power below one is infinitely steep.
_power_of_speed = de * (de**2 + SLOW**2) ** ((_power.symbol - 1) / 2)

nonlinear_viscous = Effect(
    name="nonlinear_viscous",
    title="Viscous friction that grows with a power of the speed, slower (grease) or faster (churning oil)",
    forces={e: _at_one.symbol * _power_of_speed},
    parameters=(_at_one, _power),
    # A power of one is viscous friction; a higher one may be missing from that, as in polynomials of gears.
    proper=Or(_power.symbol > 1.1, And(_power.symbol <= 0.9, _at_one.symbol >= 0)),
    citation="Waiboer, Aarts and Jonker 2005; Bittencourt and Gunnarsson 2012",
    needs="speeds up to the rated one and below a third of it",
    confounders=("viscous", "coulomb", "stribeck"),
    experiment="constant speeds from slow to rated, at least five levels",
)

_cosine, _sine = Parameter("cosine", "N.m"), Parameter("sine", "N.m")
_orders = tuple(float(order) for order in (1, 2, 3, *range(4, 31, 2)))  # of bearings, and of teeth
_order = Parameter("order", "1", start=1.0, lower=0, grid=_orders, periodic=True)

position_dependent_friction = Effect(
    name="position_dependent_friction",
    title="Dry friction whose level changes periodically with the angle",
    forces={e: sign(de) * (_cosine.symbol * cos(_order.symbol * e) + _sine.symbol * sin(_order.symbol * e))},
    parameters=(_cosine, _sine, _order),
    citation="Armstrong-Hélouvry 1991",
    needs="a turn of the joint, or as much of a period as it can turn, in both directions",
    confounders=("coulomb", "load_dependent_friction"),
    experiment="slow constant speed over the whole range, forward and backward",
)

_drift = Parameter("drift", "N.m/rad")

viscous_drift = Effect(
    name="viscous_drift",
    title="Viscous friction that changes over the log and settles, as when the grease warms up",
    forces={e: _drift.symbol * elapsed * de},
    parameters=(_drift, settling),
    citation="Bittencourt and Gunnarsson 2012",
    needs="a motion that repeats from the beginning to the end of the log",
    coverage=Coverage(Abs(de) > 0.01, 0.5),
    confounders=("viscous", "coulomb"),
    experiment="the same motion after a cold and after a warm start",
)

_rate = Parameter("rate", "N.m/s")

coulomb_drift = Effect(
    name="coulomb_drift",
    title="Coulomb friction that changes over the log and settles, as when a seal runs in",
    forces={e: _rate.symbol * elapsed * sign(de)},
    parameters=(_rate, settling),
    citation="Bittencourt and Gunnarsson 2012",
    needs="a motion that repeats from the beginning to the end of the log",
    coverage=Coverage(Abs(de) > 0.01, 0.5),
    confounders=("coulomb", "viscous_drift"),
    experiment="the same motion, at two speeds, after a cold and after a warm start",
)

directional_drift = Effect(
    name="directional_drift",
    title="Direction-dependent viscous friction that changes over the log and settles",
    forces={e: _drift.symbol * elapsed * Abs(de)},
    parameters=(_drift, settling),
    excess_over="asymmetric_coulomb",
    citation="Bittencourt and Gunnarsson 2012, for each direction on its own",
    needs="a motion in both directions that repeats from the beginning to the end of the log",
    coverage=Coverage(Abs(de) > 0.01, 0.5),
    confounders=("asymmetric_coulomb", "offset", "viscous_drift"),
    experiment="the same motion after a cold and after a warm start",
)
