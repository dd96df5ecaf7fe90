"""The command line: where robot, FMU and identification are put together."""

import sys
from collections.abc import Sequence
from pathlib import Path

import click
from rich.table import Table

from flexfmu.build import BuildError, export_fmu
from flexfmu.simulate import LoadedFmu
from flexfmu.ssp import export_ssp
from flexmodels.effects import CATALOGUE
from flexmodels.effects.effect import sheet
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot, RobotError
from pyident.cli.data import data, log
from pyident.cli.judge import add_command, compare_command, diagnose_command
from pyident.cli.outputs import FMU, LOG, ROBOT, OutputFolder
from pyident.cli.robots import robots
from pyident.cli.shared import console
from pyident.cli.shared import effects_option as _effects
from pyident.cli.shared import json_option as _json
from pyident.cli.shared import output_option as _output
from pyident.cli.shared import progress_bar as _progress
from pyident.cli.shared import reported as _reported
from pyident.cli.shared import write_json as _write_json
from pyident.cli.trust import trust_command
from pyident.estimation.base_parameters import weakest_directions
from pyident.estimation.identify import Identified, identify
from pyident.estimation.lock_unlogged import locked
from pyident.logs.foreign import open_robot_log, robot_log
from pyident.logs.log import Log, Sampled, write_log
from pyident.logs.mapping import read_mapping
from pyident.refinement.output_error import output_error
from pyident.refinement.remove_bias import correct_by_replicas
from pyident.simulation.fmu_runs import FmuRuns, simulate_robot
from pyident.simulation.references import load_experiment, read_experiment
from pyident.simulation.workers import scheduler_configured
from pyident.sweep.plan import load_study_plan
from pyident.sweep.run import run_plan
from pyident.sweep.studies import find_study, study_names
from pyident.sweep.summary import failures, summary

_scheduler = click.option("--scheduler", metavar="ADDRESS", help="Dask cluster, as tcp://host:8786.")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="flexident")
def main() -> None:
    """Model, simulate as FMU and identify robots with flexible joints.

    MODEL is a shipped robot's name (see `pyident robots`) or a TOML file.
    """


for _command in (robots, log, data, compare_command, diagnose_command, add_command, trust_command):
    main.add_command(_command)


@main.command()
@click.argument("name", required=False)
@_json
@_reported
def effects(name: str | None, json_file: str | None) -> None:
    """List the laws that a robot file may name, or show what is known of one.

    Example: pyident effects stribeck
    """
    if name is not None and name not in CATALOGUE:
        raise RobotError(f"unknown effect {name!r}; known are {', '.join(sorted(CATALOGUE))}")
    chosen = CATALOGUE if name is None else {name: CATALOGUE[name]}
    if name is None:
        table = Table("effect", "law", "parameters", "source")
        for effect in CATALOGUE.values():
            parameters = ", ".join(p.name for p in effect.parameters)
            table.add_row(effect.name, effect.title, parameters, effect.citation)
    else:
        table = Table(name, show_lines=True)
        table.add_column(CATALOGUE[name].title)
        for key, text in sheet(CATALOGUE[name]).items():
            table.add_row(key, text)
    console.print(table)
    _write_json(json_file, {n: {"title": e.title} | sheet(e) for n, e in chosen.items()})


@main.command()
@click.argument("model")
@_output(FMU)
@_effects
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

    A file that ends in .ssp holds plant and controller as two FMUs (FMI 2.0) and their connections.

    Example: pyident export four_link -o arm.fmu --fmi 3
    """
    robot = _simulable(model)
    split = output.endswith(".ssp")
    if split and fmi != "2":
        raise BuildError(f"{output}: SSP 1.0 holds FMUs of FMI 2.0; leave out --fmi {fmi}")
    with console.status("generating and compiling"):
        if split:
            path = export_ssp(equations(robot), output, platforms=platforms)  # pyright: ignore
        else:
            path = export_fmu(equations(robot), output, fmi=int(fmi), platforms=platforms)  # pyright: ignore
    click.echo(f"wrote {path}")
    _write_json(json_file, {"ssp" if split else "fmu": str(path), "parameters": robot.parameters})


@main.command()
@click.argument("model")
@click.option(
    "--experiment", required=True, help="identification, line, or a file with time and joint{k}.r columns."
)
@_output(LOG)
@_effects
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
@_output(ROBOT, required=False)
@_effects
@click.option("--robust", is_flag=True, help="Give single equations that stick out less weight (Huber).")
@click.option(
    "--refine", is_flag=True, help="Go on until the simulated FMU follows the logs (a minute or so)."
)
@click.option("--mapping", metavar="FILE", help="Names, units and signs of the logs' columns (TOML).")
@_json
@_reported
def identify_command(
    model: str,
    logs: tuple[str, ...],
    output: str | None,
    robust: bool,
    refine: bool,
    mapping: str | None,
    json_file: str | None,
) -> None:
    """Identify the dynamic parameters of MODEL from LOGS.

    Example: pyident identify four_link log.parquet -o identified.toml
    """
    robot = load_robot(model)
    columns = read_mapping(mapping) if mapping else None
    if refine:
        in_memory = [robot_log(log, robot, columns) for log in logs]
        robot, notes = _locked(robot, in_memory)
        found = _refined(robot, in_memory)
    else:
        opened = [open_robot_log(log, robot, columns) for log in logs]
        robot, notes = _locked(robot, opened)
        found = identify(robot, opened, robust=robust)
    _print_identified(found)
    if output:
        save_robot(found.robot, output)
        click.echo(f"wrote {output}")
    _write_json(json_file, found.json() | {"notes": notes})


@main.command()
@click.argument("names", nargs=-1, required=True, metavar="NAME...")
@click.option("-o", "--output", default="out", show_default=True, type=OutputFolder(), help="Folder.")
@_scheduler
@_json
@_reported
def study(names: tuple[str, ...], output: str, scheduler: str | None, json_file: str | None) -> None:
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
        with scheduler_configured(scheduler), _progress(name) as progress:
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


@main.command()
@click.argument("plan", type=click.Path(exists=True, dir_okay=False))
@click.option("-o", "--output", required=True, type=OutputFolder(), help="Folder.")
@_effects
@_scheduler
@click.option("--workers", type=click.IntRange(1), help="Processes of this machine.  [default: every core]")
@_json
@_reported
def sweep(plan: str, output: str, scheduler: str | None, workers: int | None, json_file: str | None) -> None:
    """Simulate the parameter sets that PLAN, a TOML file, describes; one row per run in results.parquet.

    The same call goes on after an interrupt.

    Example: pyident sweep plan.toml -o out/sweep --scheduler tcp://host:8786
    """
    read = load_study_plan(plan)
    with scheduler_configured(scheduler), _progress(f"{len(read.design)} runs") as progress:
        found = run_plan(read, output, workers=workers, progress=progress)
    described = summary(found, read.ranges)
    table = Table("result", *described.columns)
    for name, values in described.iterrows():
        table.add_row(str(name), *(f"{v:.4g}" for v in values))
    console.print(table)
    for sentence in failures(found):
        click.echo(sentence)
    click.echo(f"wrote {output}/results.parquet: {len(found)} runs")
    _write_json(json_file, {"runs": len(found), "results": described.to_dict("index")})


def _simulable(model: str) -> Robot:
    robot = load_robot(model)
    _require_controller(robot)
    return robot


def _require_controller(robot: Robot) -> None:
    if robot.controller is None:
        raise RobotError(f"robot {robot.name} has no [controller], so it cannot be simulated; add one")


def _locked(robot: Robot, logs: Sequence[Sampled]) -> tuple[Robot, list[str]]:
    """The robot as far as the logs can tell of it; what was done to both is printed and returned."""
    robot, notes = locked(robot, logs)
    notes = [note for log in logs for note in log.notes] + notes
    for note in notes:
        click.echo(f"note: {note}")
    return robot, notes


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
        table.add_row(b.expression, f"{b.value:.6g}", percent, interval)
    console.print(table)
    click.echo(f"{len(found.reduced.columns)} parameters, rank {found.solution.rank}; worst excited:")
    for sentence in weakest_directions(found.reduced, found.solution):
        click.echo(f"  {sentence}")
    errors = ", ".join(f"{joint} {error:.4g} %" for joint, error in found.relative_error.items())
    click.echo(f"relative torque error: {errors}")
