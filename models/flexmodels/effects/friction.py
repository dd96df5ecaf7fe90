"""Friction at the motor hinge: torque that opposes its speed."""

from sympy import Abs, sign

from flexmodels.effect import Effect, Parameter
from flexmodels.signals import de, e

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
)

viscous = Effect(
    name="viscous",
    title="Viscous friction",
    forces={e: _viscous.symbol * de},
    parameters=(_viscous,),
    citation="Hardeman, Aarts and Jonker, eq. (3)",
    base=True,
)

offset = Effect(
    name="offset",
    title="Constant torque: amplifier offset, asymmetric Coulomb level or an unmodelled weight",
    forces={e: _offset.symbol},
    parameters=(_offset,),
    citation="Janot, Gautier and Brunot 2019",
    base=True,
)

asymmetric_coulomb = Effect(
    name="asymmetric_coulomb",
    title="Friction that differs with the direction: half the difference of the levels and of the slopes",
    forces={e: _coulomb.symbol * Abs(sign(de)) + _viscous.symbol * Abs(de)},
    parameters=(Parameter("coulomb", "N.m"), Parameter("viscous", "N.m.s/rad")),
    citation="Janot, Gautier and Brunot 2019",
    needs="both directions, each at two speeds or more",
    confounders=("offset",),
    experiment="constant speeds in both directions, at least three levels",
)
