"""`pyident log inspect`: the mapping of a recording is found, not written."""

import click

from pyident.cli.common.outputs import MAPPING
from pyident.cli.common.shared import json_option, output_option, reported, show, write_json


@click.command(name="inspect")
@click.argument("files", nargs=-1, required=True)
@click.option(
    "--robot", "model", metavar="MODEL", help="Robot whose joints and equations help to tell the channels."
)
@click.option(
    "--rate",
    type=click.FloatRange(0, min_open=True),
    help="Samples per second, if the recording has no time.",
)
@output_option(MAPPING, required=False)
@json_option
@reported
def inspect_command(
    files: tuple[str, ...], model: str | None, rate: float | None, output: str | None, json_file: str | None
) -> None:
    """Show what FILES hold, guess their mapping and ask what cannot be guessed.

    FILES are parts of one recording, or recordings with the same columns.

    With -o the mapping is written; `log import` and every --mapping take it. The exit code is 1 while
    questions are open.

    Example: pyident log inspect raw.csv --robot tx40 -o mapping.toml
    """
    import sys

    from flexmodels.atomic import replacing
    from flexmodels.files.robot_file import load_robot
    from pyident.inspection.inspect_log import inspect_log

    found = inspect_log(files, load_robot(model) if model else None, rate)
    if output:
        with replacing(output) as file:
            file.write_text(found.toml(), encoding="utf-8")
    write_json(json_file, found.json())
    width = max(len(c.column) for c in found.channels)
    for c in found.channels:
        what = "?" if c.signal == "unknown" else c.name or c.signal
        mark = "" if c.name is None else "" if c.sure else "  ?"
        at = f"{'' if c.rate != c.rate else f'{c.rate:.4g} Hz':9}"
        turned = "sign -1 " if c.sign < 0 else ""
        show(
            f"{c.column:<{width}}  {at}{c.low:>11.4g} … {c.high:<11.4g}  {what} {c.unit or ''} {turned}{mark}"
        )
    for note in found.notes:
        show(f"note: {note}")
    for question in found.questions:
        show(f"? {question}")
    if output:
        show(f"wrote {output}")
    if found.questions:
        sys.exit(1)
