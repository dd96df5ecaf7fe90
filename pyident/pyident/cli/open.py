"""`pyident open`: the workbench in a browser."""

import click

from pyident.cli.common.shared import reported


@click.command(name="open")
@click.argument("folder", default=".", type=click.Path(file_okay=False))
@click.option(
    "--port", default=0, type=click.IntRange(0, 65535), metavar="N", help="Port.  [default: a free one]"
)
@click.option("--no-browser", is_flag=True, help="Only print the URL.")
@reported
def open_command(folder: str, port: int, no_browser: bool) -> None:
    """Open the workbench on FOLDER: compare, diagnose and add by looking and clicking.

    The folder's robot files, logs and results are those that the other commands read and write. It answers
    only on this machine, to the URL that it prints.

    Example: pyident open my_project
    """
    from pyident.workbench.server import serve

    serve(folder, port, not no_browser)
