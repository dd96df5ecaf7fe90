import re
import tempfile
from pathlib import Path

import pytest
from hostile_run import FULL, TRIED

PAGE = Path(__file__).parents[2] / "docs" / "reliability.md"
BEGIN, END = "<!-- counts of make fuzz -->", "<!-- end of counts -->"
ROW = re.compile(r"^\| ([^|]+) \| (\d+) \|$", re.MULTILINE)


@pytest.fixture(autouse=True, scope="session")
def own_temporary_folder(tmp_path_factory):
    """Nobody else writes where these tests look for what is left behind."""
    patch = pytest.MonkeyPatch()
    folder = tmp_path_factory.mktemp("temporary")
    patch.setattr(tempfile, "tempdir", str(folder))
    patch.setenv("TMPDIR", str(folder))
    patch.setenv("XDG_CONFIG_HOME", str(tmp_path_factory.mktemp("configuration")))
    yield folder
    patch.undo()


def pytest_terminal_summary(terminalreporter, exitstatus):
    if not TRIED:
        return
    listed = ", ".join(f"{count} {family}" for family, count in TRIED.items())
    terminalreporter.write_line(f"hostile inputs: {sum(TRIED.values())} ({listed})")
    if FULL and exitstatus == 0:
        _record()


def _record() -> None:
    """The counts of a full run without a fault, in the page; families that were not run keep theirs."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    inside, after = rest.split(END)
    counts = {family: int(count) for family, count in ROW.findall(inside) if family != "all"} | TRIED
    rows = [f"| {family} | {n} |" for family, n in [*sorted(counts.items()), ("all", sum(counts.values()))]]
    table = "\n".join(["| family | inputs |", "|---|---|", *rows])
    PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")
