"""`pyident study` and `pyident sweep`: many runs."""

import sys
from inspect import signature
from pathlib import Path

import click

import pyident as pi
from pyident.cli.common.outputs import OutputFolder
from pyident.cli.common.shared import (
    effects_option,
    json_option,
    progress_bar,
    reported,
    scheduler_option,
    set_option,
    show,
    write_json,
)


@click.command()
@click.argument("names", nargs=-1, required=True, metavar="NAME...")
@click.option(
    "-o", "--output", default="out", show_default=True, type=OutputFolder(), help="Folder for results."
)
@click.option("--seed", type=click.IntRange(0), help="Seed, for studies that draw their cases.")
@click.option("--cases", type=click.IntRange(1), help="Number of cases, for the same studies.")
@scheduler_option
@json_option
@reported
def study(
    names: tuple[str, ...], output: str, seed: int | None, cases: int | None, json_file: str | None
) -> None:
    """Run studies and print one table; the error about a NAME that is no study lists them all.

    Example: pyident study paper -o out
    """
    from pyident.sweep.studies import find_study, study_names
    from pyident.verbs.terminal.table import table
    from pyident.workbench.project import is_worth_opening

    chosen = [(name, find_study(name)) for name in names]
    drawn = {k: v for k, v in {"seed": seed, "cases": cases}.items() if v is not None}
    for name, run in chosen:
        if run is None:
            raise pi.RobotError(f"there is no study {name}; there are {', '.join(study_names())}")
        for option in sorted(set(drawn) - set(signature(run).parameters)):
            raise click.UsageError(f"study {name} takes no --{option}; leave it out")
    figures, rows = [], []
    for name, run in chosen:
        assert run is not None
        folder = Path(output) / name
        folder.mkdir(parents=True, exist_ok=True)
        with progress_bar(name) as progress:
            result = run(folder, progress, **drawn)
        figures += result.figures
        rows += [{"study": name} | row for row in result.rows]
        for note in result.notes:
            show(f"{name}: {note}")
    heads = ("study", "what", "value", "goal", "met")
    show(table(heads, [[str(row[head]) for head in heads] for row in rows]))
    for figure in figures:
        show(f"wrote {figure}")
    for folder in (Path(output) / name for name in names):
        if is_worth_opening(folder):
            show(f"to look at it in the workbench: pyident open {folder}")
    write_json(json_file, rows)
    if any(row["met"] == "no" for row in rows):
        sys.exit(1)


@click.command()
@click.argument("plan", type=click.Path(exists=True, dir_okay=False))
@click.option("-o", "--output", required=True, type=OutputFolder(), help="Folder for results.")
@effects_option
@scheduler_option
@click.option("--workers", type=click.IntRange(1), help="Processes on this machine.  [default: every core]")
@set_option
@click.option("--yes", is_flag=True, help="Do not ask for confirmation before a very long study.")
@json_option
@reported
def sweep(
    plan: str,
    output: str,
    workers: int | None,
    parameters: dict[str, float],
    yes: bool,
    json_file: str | None,
) -> None:
    """Simulate the parameter sets that PLAN, a TOML file, describes; one row per run in results.parquet.

    After an interruption the same call continues.

    Example: pyident sweep plan.toml -o out/sweep --scheduler tcp://host:8786
    """
    from pyident.cli.common.long_study import ask_first
    from pyident.sweep.plan import load_study_plan
    from pyident.sweep.summary import failures, summary
    from pyident.verbs.terminal.table import table

    ask_first(plan, workers, yes)
    read = load_study_plan(plan, parameters)
    with progress_bar(f"{len(read.design)} runs") as progress:
        found = pi.parameter_study(plan, output, parameters=parameters, workers=workers, progress=progress)
    described = summary(found, read.ranges)
    values = [(str(name), *(f"{v:.4g}" for v in row)) for name, row in described.iterrows()]
    show(table(("result", *described.columns), values, numbers=range(1, len(described.columns) + 1)))
    for sentence in failures(found):
        show(sentence)
    show(f"wrote {output}/results.parquet: {len(found)} runs")
    write_json(json_file, {"runs": len(found), "results": described.to_dict("index")})
