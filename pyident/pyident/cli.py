"""The command line: where robot, FMU and identification are put together."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from flexfmu.build import BuildError, export_fmu
from flexfmu.simulate import LoadedFmu, SimulationError
from flexmodels.atomic import replacing
from flexmodels.effects import CATALOGUE
from flexmodels.plant import equations
from flexmodels.robot import Robot, RobotError
from flexmodels.robot_file import load_robot, save_robot, shipped
from pyident.base_parameters import weakest_directions
from pyident.experiment_file import ExperimentError, load_experiment, read_experiment
from pyident.identify import Identified, identify
from pyident.indirect import correct_by_replicas
from pyident.log import Log, LogError, read_log, write_log
from pyident.log_file import open_log
from pyident.output_error import output_error
from pyident.pipeline import FmuRuns, simulate_robot
from pyident.studies import find_study, study_names

console = Console()
_BAD_INPUT = (RobotError, LogError, ExperimentError, SimulationError, BuildError)


def _reported(command: Callable[..., Any]) -> Callable[..., Any]:
    """Bad input ends in one sentence and exit code 2; Ctrl-C in 130."""

    @wraps(command)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except _BAD_INPUT as error:
            click.echo(f"error: {error}", err=True)
            sys.exit(2)
        except OSError as error:
            click.echo(f"error: {error.filename}: {error.strerror}", err=True)
            sys.exit(2)
        except KeyboardInterrupt:
            click.echo("stopped", err=True)
            sys.exit(130)

    return run


@contextmanager
def _progress(text: str) -> Iterator[Callable[[float], None]]:
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


def _write_json(path: str | None, content: Any) -> None:
    if path:
        with replacing(path) as file:
            file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


_json = click.option("--json", "json_file", metavar="FILE", help="Write the result for machines.")
_output = click.option(
    "-o", "--output", required=True, type=click.Path(dir_okay=False), help="File to write."
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="flexident")
def main() -> None:
    """Model, simulate as FMU and identify robots with flexible joints.

    MODEL is a shipped robot's name (see `pyident robots`) or a TOML file.
    """


@main.command()
@_json
@_reported
def robots(json_file: str | None) -> None:
    """List the robots that ship. Example: pyident robots"""
    listed = {name: load_robot(file) for name, file in shipped().items()}
    table = Table("robot", "joints", "parameters", "description")
    for name, robot in listed.items():
        table.add_row(name, str(len(robot.joints)), str(len(robot.parameters)), robot.description)
    console.print(table)
    _write_json(json_file, {name: robot.description for name, robot in listed.items()})


@main.command()
@_json
@_reported
def effects(json_file: str | None) -> None:
    """List the laws that a robot file may name. Example: pyident effects"""
    table = Table("effect", "law", "parameters", "source")
    for name, effect in CATALOGUE.items():
        table.add_row(
            name,
            effect.title,
            ", ".join(p.name for p in effect.parameters).replace("[", r"\["),
            effect.citation,
        )
    console.print(table)
    _write_json(json_file, {n: {"title": e.title, "citation": e.citation} for n, e in CATALOGUE.items()})


@main.command()
@click.argument("model")
@_output
@click.option("--fmi", type=click.Choice(["2", "3"]), default="2", show_default=True, help="Version of FMI.")
@click.option(
    "--platforms",
    type=click.Choice(["host", "all"]),
    default="host",
    show_default=True,
    help="This machine's binary, or Linux, Windows and macOS in one file.",
)
@_json
@_reported
def export(model: str, output: str, fmi: str, platforms: str, json_file: str | None) -> None:
    """Write MODEL as an FMU for model exchange and co-simulation.

    Example: pyident export four_link -o arm.fmu --fmi 3
    """
    robot = _simulable(model)
    with console.status("generating and compiling"):
        path = export_fmu(equations(robot), output, fmi=int(fmi), platforms=platforms)  # pyright: ignore
    click.echo(f"wrote {path}")
    _write_json(json_file, {"fmu": str(path), "parameters": robot.parameters})


@main.command()
@click.argument("model")
@click.option(
    "--experiment", required=True, help="identification, line, or a file with time and joint{k}.r columns."
)
@_output
@_json
@_reported
def simulate(model: str, experiment: str, output: str, json_file: str | None) -> None:
    """Simulate MODEL as an FMU and write the log (CSV, Parquet or MAT by its ending).

    MODEL may also be an FMU, of any tool, with inputs joint{k}.r and outputs joint{k}.e and so on; the
    experiment is then a file.

    Example: pyident simulate four_link --experiment identification -o log.parquet
    """
    if model.endswith(".fmu"):
        with LoadedFmu(model) as fmu, _progress(f"simulating {model}") as progress:
            plan = read_experiment(experiment, fmu.joints)
            frame = fmu.simulate(plan, progress=progress)
    else:
        robot = _simulable(model)
        plan = load_experiment(robot, experiment)
        with _progress(f"simulating {robot.name}") as progress:
            frame = simulate_robot(robot, plan, progress=progress)
    write_log(Log(frame, output), output)
    click.echo(f"wrote {output}: {len(frame)} samples, {plan.time[-1]:g} s")
    _write_json(json_file, {"log": output, "samples": len(frame), "duration_s": float(plan.time[-1])})


@main.command(name="identify")
@click.argument("model")
@click.argument("logs", nargs=-1, required=True)
@click.option("-o", "--output", type=click.Path(dir_okay=False), help="Robot file to write.")
@click.option("--robust", is_flag=True, help="Give single equations that stick out less weight (Huber).")
@click.option(
    "--refine", is_flag=True, help="Go on until the simulated FMU follows the logs (a minute or so)."
)
@_json
@_reported
def identify_command(
    model: str, logs: tuple[str, ...], output: str | None, robust: bool, refine: bool, json_file: str | None
) -> None:
    """Identify the dynamic parameters of MODEL from LOGS.

    Example: pyident identify four_link log.parquet -o identified.toml
    """
    robot = load_robot(model)
    if refine:
        found = _refined(robot, [read_log(log, robot.columns) for log in logs])
    else:
        found = identify(robot, [open_log(log, robot.columns) for log in logs], robust=robust)
    _print_identified(found)
    if output:
        save_robot(found.robot, output)
        click.echo(f"wrote {output}")
    _write_json(json_file, found.json())


@main.command()
@click.argument("names", nargs=-1, required=True, metavar="NAME...")
@click.option(
    "-o", "--output", default="out", show_default=True, type=click.Path(file_okay=False), help="Folder."
)
@_json
@_reported
def study(names: tuple[str, ...], output: str, json_file: str | None) -> None:
    """Run studies and print one table. Example: pyident study paper -o out"""
    chosen = [(name, find_study(name)) for name in names]
    for name, run in chosen:
        if run is None:
            raise RobotError(f"there is no study {name}; there are {', '.join(study_names())}")
    table = Table("study", "what", "value", "goal", "met")
    figures, rows = [], []
    for name, run in chosen:
        assert run is not None
        folder = Path(output) / name
        folder.mkdir(parents=True, exist_ok=True)
        with _progress(name) as progress:
            result = run(folder, progress)
        figures += result.figures
        rows += [{"study": name} | row for row in result.rows]
        for note in result.notes:
            click.echo(f"{name}: {note}")
    for row in rows:
        table.add_row(*(str(row[key]) for key in ("study", "what", "value", "goal", "met")))
    console.print(table)
    for figure in figures:
        click.echo(f"wrote {figure}")
    _write_json(json_file, rows)
    if any(row["met"] == "no" for row in rows):
        sys.exit(1)


def _simulable(model: str) -> Robot:
    robot = load_robot(model)
    _require_controller(robot)
    return robot


def _require_controller(robot: Robot) -> None:
    if robot.controller is None:
        raise RobotError(f"robot {robot.name} has no [controller], so it cannot be simulated; add one")


def _refined(robot: Robot, logs: list[Log]) -> Identified:
    """Regression, bias removed by replicas, then output error."""
    _require_controller(robot)
    with FmuRuns(robot) as runs:
        with _progress("removing the regression's bias") as progress:
            start = correct_by_replicas(robot, logs, runs, progress)
        with _progress("output error") as progress:
            return output_error(robot, logs, start, runs, progress=progress)[0]


def _print_identified(found: Identified) -> None:
    table = Table("base parameter", "value", "std %", "95 % interval")
    for b in found.base:
        percent = f"{100 * b.std / abs(b.value):.2g}" if b.value else "-"
        interval = f"{b.value - 1.96 * b.std:.5g} … {b.value + 1.96 * b.std:.5g}"
        table.add_row(b.expression.replace("[", r"\["), f"{b.value:.6g}", percent, interval)
    console.print(table)
    click.echo(f"{len(found.reduced.columns)} parameters, rank {found.solution.rank}; worst excited:")
    for sentence in weakest_directions(found.reduced, found.solution):
        click.echo(f"  {sentence}")
    errors = ", ".join(f"{joint} {error:.4g} %" for joint, error in found.relative_error.items())
    click.echo(f"relative torque error: {errors}")
