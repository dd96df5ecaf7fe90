"""Robots as FMUs: a log of one, the file itself, and many runs with other parameters."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from flexfmu.build import BuildError
from flexfmu.build import export_fmu as build
from flexfmu.foreign.parent import SILENCE, ForeignFmu
from flexmodels.files.robot_file import robot_text
from flexmodels.inputs import Experiment
from flexmodels.mechanics.plant import equations
from flexmodels.robot import RobotError
from pyident.logs.foreign import robot_log
from pyident.logs.log import Log
from pyident.refinement.instruments.stand_in import driven
from pyident.simulation.fmu_runs import simulate_robot
from pyident.simulation.free_run import WINDOW, run_freely
from pyident.simulation.references import load_experiment, read_experiment
from pyident.verbs.inputs import Columns, Model, mapping_of, robot_of, simulable

if TYPE_CHECKING:
    import pandas as pd

Progress = Callable[[float], None]
_EXPORTS = (".fmu", ".ssp", ".mo")


def simulate(
    model: Model,
    experiment: Experiment | str | Path,
    *,
    parameters: Mapping[str, float] | None = None,
    mapping: Columns | None = None,
    allow_effects: bool = False,
    time_limit: float = SILENCE,
    window: int = WINDOW,
    progress: Progress | None = None,
) -> Log:
    """Simulate a robot as an FMU, or an FMU of any tool, and return its log.

    model        as in `identify`, or the path of an FMU with inputs joint{k}.r and outputs joint{k}.e
    experiment   `identification` or `line` of the robot file, a file with time and joint{k}.r, or both
                 as an Experiment
    parameters   values that replace the model's own, by name, in SI units
    mapping      of the experiment's columns: a log of other names is replayed under its own commands
    time_limit   seconds without progress after which an FMU, which runs in a process of its own, is stopped
    window       a robot without [controller] and [servo] runs freely under the torques of a recorded log,
                 from where its first `window` positions say; they stand in the result as they were measured
    The others as in `identify`. Raises RobotError, ExperimentError, LogError, SimulationError, BuildError.
    """
    if not isinstance(model, str | Path) or Path(model).suffix != ".fmu":
        robot = robot_of(model, parameters, allow_effects)
        if not driven(robot) and not isinstance(experiment, Experiment) and Path(experiment).is_file():
            recording = robot_log(experiment, robot, mapping_of(mapping))
            return run_freely(robot, recording, window, progress)
        plan = (
            experiment
            if isinstance(experiment, Experiment)
            else load_experiment(simulable(robot), str(experiment), mapping_of(mapping))
        )
        frame = simulate_robot(simulable(robot), plan, progress=progress)
        return Log(frame.assign(time=frame["time"] + plan.began), f"simulation of {robot.name}")
    if mapping is not None:
        raise RobotError(f"{model}: a mapping needs a robot file; import the log first (pyident log import)")
    fmu = ForeignFmu(model, time_limit)
    plan = experiment if isinstance(experiment, Experiment) else read_experiment(str(experiment), fmu.joints)
    return Log(fmu.simulate(plan, dict(parameters or {}), progress=progress), f"simulation of {model}")


def export_fmu(
    model: Model,
    path: str | Path,
    fmi: Literal[2, 3] = 2,
    *,
    part: Literal["arm", "plant"] = "arm",
    platforms: Literal["host", "all"] = "host",
    parameters: Mapping[str, float] | None = None,
    allow_effects: bool = False,
) -> Path:
    """Write a robot as an FMU for model exchange and co-simulation; its path.

    path        ends in .fmu, in .ssp for plant and controller as two FMUs (FMI 2) and their connections, or
                in .mo for Modelica text
    fmi         version of the standard, 2 or 3
    part        the arm with its controller, or the plant alone, whose inputs are the motor torques: that of a
                robot without [controller] too
    platforms   this machine's binary, or Linux, Windows and macOS in one file
    parameters  values that replace the model's own, by name, in SI units
    The others as in `identify`. Raises RobotError, BuildError.
    """
    from flexfmu.build import without_controller
    from flexfmu.code.modelica import export_modelica
    from flexfmu.ssp import export_ssp

    robot = robot_of(model, parameters, allow_effects)
    if Path(path).suffix not in _EXPORTS:
        raise BuildError(f"{path}: an exported model must end in {', '.join(_EXPORTS)}")
    if Path(path).suffix == ".mo":
        if part == "plant":
            raise BuildError(f"{path}: Modelica text holds the arm with its controller, not the plant alone")
        return export_modelica(robot, path)
    if Path(path).suffix != ".ssp":
        alone = "add one, or export the plant alone (--part plant)"
        plant = (
            without_controller(equations(robot)) if part == "plant" else equations(simulable(robot, alone))
        )
        text = robot_text(robot).encode()
        return Path(build(plant, path, fmi=fmi, platforms=platforms, model=text))
    robot = simulable(robot)
    if part == "plant":
        raise BuildError(f"{path}: an SSP holds plant and controller; name it .fmu for the plant alone")
    if fmi != 2:
        raise BuildError(f"{path}: SSP 1.0 holds FMUs of FMI 2.0; leave out --fmi {fmi}")
    return Path(export_ssp(equations(robot), path, platforms=platforms))


def parameter_study(
    plan: "str | Path | pd.DataFrame",
    folder: str | Path,
    *,
    model: Model | None = None,
    experiment: Experiment | str | Path | None = None,
    parameters: Mapping[str, float] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    allow_effects: bool = False,
    progress: Progress | None = None,
) -> "pd.DataFrame":
    """Simulate many sets of parameters; one row per run, which also stands in folder/results.parquet.

    plan         a plan (TOML), or a design: a row per run, columns are parameters' names, values in SI units
    model, experiment   of a design, as in `simulate`; a plan names its own
    parameters   values that replace the model's own in every run
    scheduler    address of a Dask cluster; none: the configured one, else `workers` processes here
    The same call goes on after an interrupt. The others as in `identify`.
    Raises StudyError, WorkersError, RobotError, SimulationError.
    """
    from pyident.simulation.processes.dask_cluster import scheduler_configured
    from pyident.sweep.plan import load_study_plan
    from pyident.sweep.run import parameter_study as run_design
    from pyident.sweep.run import run_plan
    from pyident.sweep.store import StudyError

    with scheduler_configured(scheduler):
        if isinstance(plan, str | Path):
            read = load_study_plan(plan, parameters, allow_effects)
            return run_plan(read, folder, workers=workers, progress=progress)
        if model is None or experiment is None:
            raise StudyError("a design needs its model and its experiment; give both, or a plan (TOML)")
        robot = simulable(robot_of(model, parameters, allow_effects))
        planned = (
            experiment if isinstance(experiment, Experiment) else load_experiment(robot, str(experiment))
        )
        return run_design(plan, robot, planned, folder, workers=workers, progress=progress)
