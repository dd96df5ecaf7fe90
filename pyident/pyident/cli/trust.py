"""`pyident trust`: which Python files of effects and metrics may run."""

import click

from pyident.cli.common.shared import json_option, reported, show, write_json


@click.command(name="trust")
@click.argument("files", nargs=-1, required=True, metavar="FILE.py...")
@json_option
@reported
def trust_command(files: tuple[str, ...], json_file: str | None) -> None:
    """Let Python files of effects or metrics run whenever a robot file or a plan names them.

    What is recorded, in your user configuration, is their content: a file that changes is no longer trusted.

    Example: pyident trust my_effects.py
    """
    from flexmodels.effects.trust import trust

    digests = {file: trust(file) for file in files}
    for file, digest in digests.items():
        show(f"trusted {file} (SHA-256 {digest})")
    write_json(json_file, digests)
