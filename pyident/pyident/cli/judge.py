"""Commands that judge a model: compare, diagnose, add."""

import sys
from pathlib import Path

import click
from rich.table import Table

from flexmodels.atomic import replacing
from flexmodels.files.robot_file import load_robot, save_robot, shipped
from flexmodels.robot import Robot, RobotError
from pyident.cli.outputs import DRAFT, PAGE, ROBOT, Output
from pyident.cli.shared import (
    console,
    effects_option,
    json_option,
    output_option,
    progress_bar,
    reported,
    write_json,
)
from pyident.comparison.compare import Comparison, Error, compare
from pyident.diagnosis.diagnose import diagnose
from pyident.diagnosis.result import Diagnosis, Named
from pyident.extension.add_effect import Extended, add_effect, split
from pyident.logs.foreign import robot_log
from pyident.logs.log import Log
from pyident.report.comparison import write_comparison
from pyident.report.diagnosis_page import write_diagnosis
from pyident.simulation.fmu_runs import FmuRuns, RivalRuns

_SHOWN = 4  # names in a line


@click.command(name="compare")
@click.argument("models_and_logs", nargs=-1, required=True, metavar="MODEL [MODEL] LOG...")
@output_option(PAGE, required=False)
@effects_option
@json_option
@reported
def compare_command(models_and_logs: tuple[str, ...], output: str | None, json_file: str | None) -> None:
    """Show where an identified MODEL fails on logs, and how much beside the method's own floor.

    The floor is what fit and simulation leave on replicas: logs that the model itself made over the same
    motion with the same sensor noise. With two models, OLD and NEW, both are shown side by side.

    \b
    Example: pyident compare identified.toml log.parquet -o where.html
             pyident compare identified.toml extended.toml validation.parquet
    """
    models, paths = _models_and_logs(models_and_logs)
    found = []
    for model in models:
        robot = load_robot(model)
        logs = _read(robot, paths)
        with progress_bar(f"{model} and its replicas") as progress:
            found.append(compare(robot, logs, FmuRuns, progress))
    for model, c in zip(models, found, strict=True):
        click.echo(f"{model}: {c.sentence}" if len(models) > 1 else c.sentence)
    _print_comparison(models, found)
    if output:
        write_comparison(Path(output), models, found)
        click.echo(f"wrote {output}")
    contents = [c.json() for c in found]
    write_json(json_file, contents[0] if len(found) == 1 else contents[1] | {"old": contents[0]})


@click.command(name="diagnose")
@click.argument("model")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--holdout", multiple=True, metavar="LOG", help="Log to judge on.  [default: the last, or its last third]"
)
@click.option(
    "--draft",
    type=Output(DRAFT),
    metavar="FILE.py",
    help="Effect file to propose where no law explains the residual.  [needs: flexident[symbolic]]",
)
@output_option(PAGE, required=False)
@effects_option
@json_option
@reported
def diagnose_command(
    model: str,
    logs: tuple[str, ...],
    holdout: tuple[str, ...],
    draft: str | None,
    output: str | None,
    json_file: str | None,
) -> None:
    """Say which effect MODEL lacks in its logs: a name, names that cannot be told apart, none we know, or
    nothing.

    The model is fitted to the logs; its own masses, frictions and stiffnesses are not used. The exit code is
    1 when something is missing.

    Example: pyident diagnose my_arm.toml a.parquet b.parquet c.parquet -o diagnosis.html
    """
    robot = load_robot(model)
    parts = split(_read(robot, logs), _read(robot, holdout))
    with progress_bar("fitting, replicas, search") as progress:
        found = diagnose(robot, parts.fitted, FmuRuns, RivalRuns, parts.unseen, progress, draft is not None)
    _print_diagnosis(found)
    if output:
        write_diagnosis(found, output, model)
        click.echo(f"wrote {output}")
    if draft and found.draft:
        with replacing(draft) as file:
            file.write_text(found.draft, encoding="utf-8")
        click.echo(f"wrote {draft}")
    write_json(json_file, found.json())
    if found.verdict != "nothing_detectable":
        sys.exit(1)


@click.command(name="add")
@click.argument("model")
@click.argument("effect")
@click.option("--joint", required=True, type=int, metavar="K", help="Where the effect acts, from 1.")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--holdout", multiple=True, metavar="LOG", help="Log to judge on.  [default: the last, or its last third]"
)
@output_option(ROBOT)
@effects_option
@json_option
@reported
def add_command(
    model: str,
    effect: str,
    joint: int,
    logs: tuple[str, ...],
    holdout: tuple[str, ...],
    output: str,
    json_file: str | None,
) -> None:
    """Add EFFECT to MODEL, fit it to logs, and write it if held-out data are met better.

    Both the equations' error and the FMU's must fall on data that were not fitted; else nothing is written
    and the exit code is 1.

    Example: pyident add identified.toml stribeck --joint 2 a.parquet b.parquet -o extended.toml
    """
    robot = load_robot(model)
    with progress_bar(f"{effect} at joint {joint}") as progress:
        found = add_effect(robot, joint, effect, _read(robot, logs), _read(robot, holdout), FmuRuns, progress)
    _print_waterfall(found)
    write_json(json_file, found.json())
    if not found.accepted:
        click.echo(found.reason)
        sys.exit(1)
    save_robot(found.robot, output)
    click.echo(f"wrote {output}")


def _models_and_logs(given: tuple[str, ...]) -> tuple[list[str], list[str]]:
    models = [word for word in given[:2] if word.endswith(".toml") or word in shipped()]
    logs = [word for word in given if word not in models]
    if not models or given[: len(models)] != tuple(models):
        raise RobotError(f"{given[0]} is neither a shipped robot nor a .toml file; give the model first")
    if not logs:
        raise RobotError("there is no log to compare with; give one or more behind the model")
    return models, logs


def _read(robot: Robot, paths: tuple[str, ...] | list[str]) -> list[Log]:
    return [robot_log(path, robot) for path in paths]


def _print_comparison(models: list[str], found: list[Comparison]) -> None:
    heads = [h for model in models for h in (model if len(models) > 1 else "rmse", "% of signal", "x floor")]
    for i, log in enumerate(found[0].logs):
        table = Table(log.log, *heads, "floor %")
        for kind in ("equations", "simulation"):
            for name in getattr(log, kind):
                errors: list[Error] = [getattr(c.logs[i], kind)[name] for c in found]
                cells = [
                    x
                    for e in errors
                    for x in (f"{e.rmse:.3g} {e.unit}", f"{e.nrmse_percent:.3g}", f"{e.ratio:.3g}")
                ]
                what = f"{kind[:-1] if kind == 'equations' else 'simulated'} {name}"
                table.add_row(what, *cells, f"{errors[-1].floor_percent:.3g}")
        console.print(table)


def _print_diagnosis(found: Diagnosis) -> None:
    for note in found.notes:
        click.echo(f"note: {note}")
    click.echo(found.sentence)
    table = Table("finding", "share of the excess", "fall on held-out data", "parameters")
    for finding in found.findings:
        best = finding.tie[0]
        names = " or ".join(f"{n.effect} at {n.joint}" for n in finding.tie)
        held = "-" if finding.heldout_gain_percent is None else f"{finding.heldout_gain_percent:.0f} %"
        values = ", ".join(_value(best, name) for name in best.values)
        table.add_row(names, f"{finding.share_percent:.0f} %", held, values)
    if found.findings:
        console.print(table)
    for sentence in (
        *found.depends_on,
        *(f"to separate: {f.experiment}" for f in found.findings if f.experiment),
    ):
        click.echo(sentence)
    hidden = [f"{x.effect} at {x.joint}" for x in found.limits if x.reason]
    if hidden:
        more = f" and {len(hidden) - _SHOWN} more" if len(hidden) > _SHOWN else ""
        named = ", ".join(hidden[:_SHOWN])
        click.echo(f"these logs cannot show {named}{more}; the page (-o) says why, and which motion would")


def _value(n: Named, name: str) -> str:
    if n.std[name] == float("inf") and name not in n.nonlinear:
        return f"{name} not determined by itself"
    return f"{name} {n.values[name]:.4g} {n.units[name]}"


def _print_waterfall(found: Extended) -> None:
    table = Table("rms on held-out data", "base", "with the effect", "floor", "unit")
    for step in found.waterfall:
        values = (f"{v:.4g}" for v in (step.before, step.after, step.floor))
        table.add_row(step.name, *values, step.unit)
    console.print(table)
