"""Tutorials on measured data run only where these are; elsewhere the page says so in its first lines."""

from pathlib import Path
from typing import Any

from pyident.logs.datasets import fetch
from pyident.logs.log import LogError

NEEDS = {"tutorials/emps": "emps", "tutorials/tx40": "tx40"}
_SENTENCE = """
:::{{admonition}} This page was built without its measured data
:class: warning

The cells below were not run, because data set `{name}` was not there. `pyident data fetch {name}` downloads
it, or set `PYIDENT_DATA` to a folder that has it; then build again.
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
    return all(Path(file).is_file() for file in files)


def _leave_out(app: Any, config: Any) -> None:
    missing = [f"{page}.md" for page, name in NEEDS.items() if not is_here(name)]
    config.nb_execution_excludepatterns = [*config.nb_execution_excludepatterns, *missing]


def _say_so(app: Any, page: str, source: list[str]) -> None:
    if page in NEEDS and not is_here(NEEDS[page]):
        head, title, rest = source[0].partition("\n# ")
        heading, _, body = rest.partition("\n")
        source[0] = f"{head}{title}{heading}\n{_SENTENCE.format(name=NEEDS[page])}{body}"
