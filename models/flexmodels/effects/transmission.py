"""The flexible hinge: stress resultants of the drive (1) and the two bendings (2, 3)."""

from sympy import Symbol

from flexmodels.effect import Effect, Parameter
from flexmodels.signals import deps, eps

_k = {i: Parameter(f"k[{i}]", "N.m/rad", lower=0) for i in eps}
_d = {i: Parameter(f"d[{i}]", "N.m.s/rad", lower=0) for i in eps}


def _each(coefficients: dict[int, Parameter], rates: dict[int, Symbol]):
    return {eps[i]: coefficients[i].symbol * rates[i] for i in eps}


stiffness = Effect(
    name="stiffness",
    title="Stiffness of the drive and of the bearings",
    forces=_each(_k, eps),
    parameters=tuple(_k.values()),
    citation="Hardeman, Aarts and Jonker, eq. (4)",
    base=True,
)

damping = Effect(
    name="damping",
    title="Structural damping of the drive and of the bearings",
    forces=_each(_d, deps),
    parameters=tuple(_d.values()),
    citation="Hardeman, Aarts and Jonker, eq. (4)",
    base=True,
)
