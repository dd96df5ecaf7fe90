"""One variable of an FMU, and the arrays of FMI 3.0 that view several."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Variable:
    """One variable; its place in `variables` is its value reference.

    derivative_of   name of the variable whose time derivative it is
    """

    name: str
    causality: str
    variability: str
    unit: str
    description: str
    start: float | None = None
    minimum: float | None = None
    nominal: float | None = None
    derivative_of: str | None = None

    @property
    def initial(self) -> str | None:
        return {"parameter": "exact", "input": None}.get(self.causality, "calculated")


@dataclass(frozen=True)
class Array:
    """A view of neighbouring variables as one array (FMI 3.0)."""

    name: str
    first: str
    size: int
    description: str


def arrays(joints: int) -> list[Array]:
    """The arrays of FMI 3.0, in the order of `arrays` in runtime/fmi3/fmi3.c; inputs are scalars only."""
    n = joints
    return [
        Array("joint.e", "joint1.e", n, "Positions of all motor hinges"),
        Array("joint.tau", "joint1.tau", n, "Motor torques of all joints"),
        Array("joint.friction", "joint1.friction", n, "Friction of all motor hinges"),
        Array("tip", "tip.x", 3, "Tip position in base axes"),
    ]
