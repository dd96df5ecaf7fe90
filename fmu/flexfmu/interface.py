"""What an FMU shows of itself: the arm with its controller, the plant alone, the controller alone."""

from collections.abc import Mapping
from dataclasses import dataclass

from flexfmu.dependencies import Dependencies, controller_dependencies, plant_dependencies
from flexfmu.names import c_identifier
from flexfmu.variable import Variable
from flexfmu.variables import controller_variables, states, variables
from flexmodels.mechanics.plant import Equations

_STEP_WITHOUT_CONTROLLER = 1e-3  # [s]


@dataclass(frozen=True)
class Interface:
    """Name, variables by value reference, continuous states; all that a model description needs.

    indicators   number of event indicators
    step         communication step of the default experiment [s]
    sampled      whether a controller samples inputs, which may then have slopes
    """

    name: str
    description: str
    listed: list[Variable]
    states: tuple[str, ...]
    joints: int
    indicators: int
    step: float
    sampled: bool
    dependencies: Dependencies

    @property
    def identifier(self) -> str:
        """The C identifier that names the binary."""
        return c_identifier(self.name)

    @property
    def unknowns(self) -> list[Variable]:
        """Outputs, then state rates: the order of the model structure."""
        outputs = [v for v in self.listed if v.causality == "output"]
        return outputs + [v for v in self.listed if v.derivative_of]

    @property
    def initial_unknowns(self) -> list[Variable]:
        """What initialisation computes, by value reference."""
        names = {v.name for v in self.unknowns} | set(self.states)
        names |= {v.name for v in self.listed if v.causality == "calculatedParameter"}
        return [v for v in self.listed if v.name in names]

    def references(self, names: frozenset[str]) -> list[int]:
        """Value references of variables, ascending."""
        return [i for i, v in enumerate(self.listed) if v.name in names]


def plant_interface(equations: Equations) -> Interface:
    """The arm, with its controller or (controller None) with the torques as inputs."""
    c = equations.servo or equations.controller
    kind = "with its servos" if equations.servo else "with its controller" if c else "without controller"
    return Interface(
        name=equations.name,
        description=f"{equations.description or f'Robot {equations.name}'} ({kind})",
        listed=variables(equations),
        states=states(equations),
        joints=equations.joints,
        indicators=equations.joints,
        step=c.period if c else _STEP_WITHOUT_CONTROLLER,
        sampled=c is not None,
        dependencies=plant_dependencies(equations),
    )


def controller_interface(equations: Equations, integral: Mapping[str, float]) -> Interface:
    """The digital controller alone; `integral` holds the start of every `joint{k}.I_0` [N m or N]."""
    assert equations.controller is not None
    return Interface(
        name=f"{equations.name}_controller",
        description=f"Digital PID of robot {equations.name}",
        listed=controller_variables(equations, integral),
        states=(),
        joints=equations.joints,
        indicators=0,
        step=equations.controller.period,
        sampled=True,
        dependencies=controller_dependencies(equations.joints),
    )
