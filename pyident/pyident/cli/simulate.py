"""`pyident simulate`: a robot or an FMU over an experiment."""

import click

from flexfmu.simulate import LoadedFmu
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot, RobotError
from pyident.cli.outputs import LOG
from pyident.cli.settings import parsed, set_option, with_set
from pyident.cli.shared import effects_option, json_option, output_option, progress_bar, reported, write_json
from pyident.logs.log import Log, write_log
from pyident.logs.mapping import read_mapping
from pyident.simulation.fmu_runs import simulate_robot
from pyident.simulation.references import load_experiment, read_experiment


@click.command(name="simulate")
@click.argument("model")
@click.option(
    "--experiment", required=True, help="identification, line, or a file with time and joint{k}.r columns."
)
@click.option("--mapping", metavar="FILE", help="Names, units and signs of the experiment's columns (TOML).")
@set_option
@output_option(LOG)
@effects_option
@json_option
@reported
def simulate_command(
    model: str,
    experiment: str,
    mapping: str | None,
    settings: tuple[str, ...],
    output: str,
    json_file: str | None,
) -> None:
    """Simulate MODEL as an FMU and write the log (CSV, Parquet or MAT by its ending).

    A recorded log as experiment is replayed under its own commands. MODEL may also be an FMU, of any tool,
    with inputs joint{k}.r and outputs joint{k}.e and so on; the experiment is then a file.

    Example: pyident simulate four_link --experiment identification --set joint1.coulomb=40 -o log.parquet
    """
    columns = read_mapping(mapping) if mapping else None
    if model.endswith(".fmu"):
        if columns is not None:
            raise RobotError("--mapping needs a robot file; import the log first: pyident log import")
        with LoadedFmu(model) as fmu, progress_bar(f"simulating {model}") as progress:
            plan = read_experiment(experiment, fmu.joints)
            frame = fmu.simulate(plan, parsed(settings), progress=progress)
    else:
        robot = with_set(load_robot(model), settings)
        require_loop(robot)
        plan = load_experiment(robot, experiment, columns)
        with progress_bar(f"simulating {robot.name}") as progress:
            frame = simulate_robot(robot, plan, progress=progress)
    frame["time"] += plan.began
    write_log(Log(frame, output), output)
    click.echo(f"wrote {output}: {len(frame)} samples, {plan.time[-1]:g} s")
    write_json(json_file, {"log": output, "samples": len(frame), "duration_s": float(plan.time[-1])})


def require_loop(robot: Robot) -> None:
    """Raises RobotError unless something drives the joints."""
    if robot.controller is None and robot.servo is None:
        raise RobotError(
            f"robot {robot.name} has no [controller] and no [servo], so it cannot be simulated; add one"
        )
