"""The motor's own laws."""

from flexmodels.effect import Effect, Parameter
from flexmodels.signals import dde, e

_J_m = Parameter("J_m", "kg.m2", lower=0)

motor_inertia = Effect(
    name="motor_inertia",
    title="Rotor and gear inertia, seen at the joint",
    forces={e: _J_m.symbol * dde},
    parameters=(_J_m,),
    citation="Hardeman, Aarts and Jonker, eq. (2)",
    base=True,
)
