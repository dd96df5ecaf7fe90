"""Robot -> FMU -> log, in one call. Beside the command line the only place that joins the packages."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import pandas as pd
from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment
from flexmodels.plant import equations
from flexmodels.robot import Robot


def simulate_robot(
    robot: Robot, experiment: Experiment, progress: Callable[[float], None] | None = None
) -> pd.DataFrame:
    """Export the robot, simulate the FMU over the experiment and return the log's frame.

    Raises BuildError, SimulationError.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = export_fmu(equations(robot), Path(folder) / "plant.fmu")
        with LoadedFmu(path) as fmu:
            return fmu.simulate(experiment, progress=progress)
