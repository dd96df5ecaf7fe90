import tempfile
from pathlib import Path

import pytest
from hostile_run import FULL, TRIED

PAGE = Path(__file__).parents[2] / "docs" / "reliability.md"
BEGIN, END = "<!-- counts of make fuzz -->", "<!-- end of counts -->"


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
    if FULL:
        failed = len(terminalreporter.stats.get("failed", [])) + len(terminalreporter.stats.get("error", []))
        _record(failed)


def _record(failed: int) -> None:
    """The counts of a full run, between their marks in the page."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    rows = [f"| {family} | {count} |" for family, count in sorted(TRIED.items())]
    table = "\n".join(["| family | inputs |", "|---|---|", *rows, f"| all | {sum(TRIED.values())} |"])
    sentence = f"Tests of this run that failed: {failed}."
    PAGE.write_text(f"{before}{BEGIN}\n{table}\n\n{sentence}\n{END}{after}", encoding="utf-8")
