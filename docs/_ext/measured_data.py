"""Tutorials on measured data run only where these are; elsewhere the page says so in its first lines."""

from pathlib import Path
from typing import Any

from pyident.logs.datasets import fetch
from pyident.logs.log import LogError

NEEDS = {"tutorials/emps": "emps", "tutorials/tx40": "tx40"}
BESIDE = {"tx40": "tx40_mdh_modified.urdf"}  # what a page needs beside the recordings
_SENTENCE = """
:::{{admonition}} This page was built without its measured data
:class: warning

The cells below were not run, because {what} was not there. `pyident data fetch {name}` downloads the
recordings, or set `PYIDENT_DATA` to a folder that has them; then build again.
:::
"""


def setup(app: Any) -> dict[str, bool]:
    app.connect("config-inited", _leave_out)
    app.connect("source-read", _say_so)
    return {"parallel_read_safe": True}


def is_here(name: str) -> bool:
    """Whether a data set lies in PYIDENT_DATA or in the cache."""
    try:
        files = fetch(name, download=False)
    except LogError:
        return False
    beside = [Path(files[0]).with_name(BESIDE[name])] if name in BESIDE else []
    return all(Path(file).is_file() for file in [*files, *beside])


def _leave_out(app: Any, config: Any) -> None:
    missing = [f"{page}.md" for page, name in NEEDS.items() if not is_here(name)]
    config.nb_execution_excludepatterns = [*config.nb_execution_excludepatterns, *missing]


def _say_so(app: Any, page: str, source: list[str]) -> None:
    if page in NEEDS and not is_here(NEEDS[page]):
        name = NEEDS[page]
        what = " or ".join([f"data set `{name}`", *([f"`{BESIDE[name]}`"] if name in BESIDE else [])])
        head, title, rest = source[0].partition("\n# ")
        heading, _, body = rest.partition("\n")
        source[0] = f"{head}{title}{heading}\n{_SENTENCE.format(name=name, what=what)}{body}"
