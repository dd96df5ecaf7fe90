"""`pyident explain`: which law would take one stretch of a residual."""

import click

import pyident as pi
from pyident.cli.common.shared import (
    effects_option,
    force_option,
    json_option,
    mapping_option,
    progress_bar,
    reported,
    set_option,
    show,
    show_notes,
    write_json,
)


@click.command(name="explain")
@click.argument("model")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option("--log", "chosen", metavar="LOG", help="Log that holds the stretch.  [default: the first log]")
@click.option(
    "--equation", metavar="COORDINATE", help="Equation, such as joint2.e.  [default: the one that fails most]"
)
@click.option(
    "--span", nargs=2, type=float, metavar="FROM TO", help="Start and end of the stretch [s].  [default: all]"
)
@click.option(
    "--band", nargs=2, type=float, metavar="FROM TO", help="Frequencies that count [Hz].  [default: all]"
)
@click.option("--holdout", multiple=True, metavar="LOG", help="Log to which nothing is fitted; repeatable.")
@effects_option
@set_option
@mapping_option
@force_option
@json_option
@reported
def explain_command(
    model: str,
    logs: tuple[str, ...],
    chosen: str | None,
    equation: str | None,
    span: tuple[float, float] | None,
    band: tuple[float, float] | None,
    holdout: tuple[str, ...],
    parameters: dict[str, float],
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Rank the laws by what each would explain of one stretch of a log, of MODEL's residual there.

    A ranking of one stretch is no verdict: what stands first may only imitate what is missing. See
    `pyident diagnose`.

    Example: pyident explain my_arm.toml a.parquet b.parquet --equation joint2.e --span 3.2 4.1
    """
    if span and not span[0] < span[1]:
        raise pi.RobotError(f"--span {span[0]:g} {span[1]:g} is empty; give the earlier time first")
    if band and not 0 <= band[0] < band[1]:
        raise pi.RobotError(f"--band {band[0]:g} {band[1]:g} is empty; give the lower frequency first")
    with progress_bar("comparing, asking every law") as progress:
        explained = pi.explain(
            model,
            logs,
            log=chosen,
            coordinate=equation,
            span=span,
            band=band,
            heldout=holdout,
            mapping=mapping,
            parameters=parameters,
            force=force,
            progress=progress,
        )
    show_notes(explained.notes)
    show(explained.summary())
    write_json(json_file, explained.to_dict())
