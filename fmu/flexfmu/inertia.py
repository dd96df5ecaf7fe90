"""Whether a plant has the inertia that it takes to move: asked before an FMU of it is written."""

from collections.abc import Mapping

import numpy as np

from flexmodels.compiling.compiler import BuildError
from flexmodels.mechanics.plant import Equations


def require_inertia(equations: Equations) -> None:
    """Raises BuildError, naming what is missing, where the mass matrix at zero position is not definite."""
    parameters = equations.parameters
    if _definite(equations, parameters):
        return
    none = [name for name, value in parameters.items() if name.endswith(".J_m") and value <= 0]
    given = parameters | dict.fromkeys(none, 1.0)
    missing = [name for name in none if not _definite(equations, given | {name: parameters[name]})]
    if not missing or not _definite(equations, given):
        raise BuildError(
            f"{equations.name} could not be simulated: its mass matrix is not positive definite; "
            "check masses, first moments and moments of inertia"
        )
    joints = " and ".join(name.split(".")[0] for name in missing)
    options = " ".join(f"--set {name}=VALUE" for name in missing)
    raise BuildError(
        f"{equations.name} could not be simulated: nothing at {joints} has inertia about its axis; give "
        f"{' and '.join(missing)} in the robot file or by {options}"
    )


def _definite(equations: Equations, parameters: Mapping[str, float]) -> bool:
    """As runtime/plant/plant.c asks at the start, where every hinge stands at zero."""
    size = equations.pivots.size1_in(0)
    pivots = np.asarray(equations.pivots(np.zeros(size), [*parameters.values()])).ravel()
    return bool((pivots > 0).all())
