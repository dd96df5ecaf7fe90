import tempfile

import pytest
from hostile_run import TRIED


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


def pytest_terminal_summary(terminalreporter):
    if TRIED:
        listed = ", ".join(f"{count} {family}" for family, count in TRIED.items())
        terminalreporter.write_line(f"hostile inputs: {sum(TRIED.values())} ({listed})")
