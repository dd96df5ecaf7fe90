"""How commands end: in one line at Ctrl-C, with nothing left of them when they are killed or run at once."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pytest
from hostile_run import counted

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name != "posix", reason="sends signals")]
COMMAND = [sys.executable, "-m", "pyident"]
ROBOT = Path(__file__).parents[1] / "robots" / "two_link.toml"
PATIENCE = 600  # [s] before a test gives up waiting
PLAN = """model = "arm.toml"
experiment = "references.csv"
runs = 4000
metrics = ["torque_rms"]
[parameters]
"joint1.coulomb" = 0.2
"""


COMMAND_THAT = """
import os, signal, time
import pyident.__main__ as command
import pyident.cli.main

{}

def main():
    try:
        meet()
    except Exception as error:
        print(error)
    time.sleep(300)
    print("went on")

pyident.cli.main.main = main
command.main()
"""
MEETINGS = {
    "a destructor": """
class Caught:
    def __del__(self):
        os.kill(os.getpid(), {signal:d})
        time.sleep(1)

def meet():
    Caught()
""",
    "a conversion for CasADi": """
import casadi

class Slow:
    def __SX__(self):
        os.kill(os.getpid(), {signal:d})
        time.sleep(1)
        return casadi.SX(1)

def meet():
    return casadi.SX.sym("x") + Slow()
""",
    "a function of CasADi that catches everything": """
def meet():
    place = {{"__name__": "casadi.casadi", "os": os}}
    exec('''def function():
        try:
            os.kill(os.getpid(), {signal:d})
        except:
            pass''', place)
    place["function"]()
""",
    "an import that is tried": """
import sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "missing":
            os.kill(os.getpid(), {signal:d})
            time.sleep(1)

sys.meta_path.insert(0, Finder())

def meet():
    try:
        import missing
    except:
        pass
""",
    "text under execution": """
def meet():
    exec("import os, signal; os.kill(os.getpid(), {signal:d})")
""",
}
STARTED: list[subprocess.Popen[str]] = []


@pytest.fixture(autouse=True)
def ended():
    """Whatever a test starts hears Ctrl-C, unlike jobs of a shell; it is not there for the next one."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    while STARTED:
        run = STARTED.pop()
        with suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)
        run.communicate()


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a robot, a short motion and a plan, and a temporary folder of its own."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.toml").write_text(ROBOT.read_text())
    (tmp_path / "plan.toml").write_text(PLAN)
    still = pd.DataFrame({"time": 0.004 * np.arange(100), "joint1.r": 0.1, "joint2.r": 0.2})
    still.to_csv(tmp_path / "references.csv", index=False)
    return tmp_path


def started(*words, **options):
    STARTED.append(
        subprocess.Popen(
            [*COMMAND, *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            **options,
        )
    )
    return STARTED[-1]


def gone(processes):
    """Whether all of them end, and those that still run."""
    _, alive = psutil.wait_procs(processes, timeout=PATIENCE)
    return [p.cmdline() for p in alive if p.status() != psutil.STATUS_ZOMBIE]


def emptied(folder):
    """What is left when those that clean up had their time."""
    until = time.monotonic() + PATIENCE
    while list(folder.glob("flexident-*")) and time.monotonic() < until:
        time.sleep(0.05)
    return list(folder.iterdir())


@pytest.mark.parametrize("module", ["click", "numpy", "pandas", "casadi", "pyident.verbs"])
def test_ctrl_c_while_modules_are_loaded(module, place):
    """The interpreter names every module that it has loaded: there the signal is sent."""
    run = started(
        "simulate", "arm.toml", "--experiment", "references.csv", "-o", "out.csv",
        env=os.environ | {"PYTHONPROFILEIMPORTTIME": "1"},
    )  # fmt: skip
    assert run.stderr is not None
    for line in run.stderr:
        if line.rsplit("|", 1)[-1].strip().split(".")[: module.count(".") + 1] == module.split("."):
            run.send_signal(signal.SIGINT)
            break
    else:
        pytest.fail(f"{module} was never loaded")
    said = [line for line in run.stderr if not line.startswith("import time:")]
    run.wait(PATIENCE)
    counted("interrupts")
    assert said == ["stopped\n"]
    assert run.returncode == 130
    assert emptied(place / "temporary") == []
    assert not (place / "out.csv").exists()


@pytest.mark.parametrize(("asked", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("meeting", MEETINGS)
def test_a_signal_is_not_lost(meeting, asked, code):
    """Python and CasADi forget what is raised there, or end by the signal itself."""
    script = COMMAND_THAT.format(MEETINGS[meeting].format(signal=asked))
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == code
    assert done.stdout == ""
    assert done.stderr == ("stopped\n" if code == 130 else "")


@pytest.mark.parametrize("seconds", [0.05, 0.2, 0.5, 1.0, 4.0])
def test_ctrl_c_to_the_whole_group_at_any_time(seconds, place):
    """As a terminal sends it: to the command, its compiler and its workers."""
    run = started("sweep", "plan.toml", "-o", "out", "--workers", "2")
    family = [psutil.Process(run.pid)]
    time.sleep(seconds)
    family += family[0].children(recursive=True)
    os.killpg(run.pid, signal.SIGINT)
    _, said = run.communicate(timeout=PATIENCE)
    counted("interrupts")
    if "stopped" in said or seconds > 2:
        assert run.returncode == 130
        assert said.splitlines()[-1] == "stopped"
        assert "Traceback" not in said
    else:  # the interpreter itself was starting, and answers in its own way
        assert run.returncode in (130, 1, -signal.SIGINT)
        assert "cli" not in said
    assert gone(family) == []
    assert emptied(place / "temporary") == []


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL], ids=lambda how: how.name)
def test_workers_end_with_their_parent(how, place):
    run = started("sweep", "plan.toml", "-o", "out", "--workers", "2")
    until = time.monotonic() + PATIENCE
    while not list(place.glob("out/parts/0*.parquet")):
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < until
        time.sleep(0.05)
    family = [psutil.Process(run.pid), *psutil.Process(run.pid).children(recursive=True)]
    assert len(family) > 2
    run.send_signal(how)
    run.communicate(timeout=PATIENCE)
    counted("kills")
    assert gone(family) == []
    assert emptied(place / "temporary") == []
    parts = [pd.read_parquet(file) for file in place.glob("out/parts/0*.parquet")]
    assert sum(map(len, parts)) > 0


def test_two_commands_at_once(place, monkeypatch):
    """Both compile into one cache that is empty, and write the same file."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(place / "cache"))
    time = 0.004 * np.arange(1500)
    moving = pd.DataFrame({f"joint{k}.r": 0.4 * np.sin((2 + k) * time) for k in (1, 2)})
    moving.assign(time=time).to_csv(place / "moving.csv", index=False)
    simulate = ("simulate", "arm.toml", "--experiment", "moving.csv", "-o", "log.csv", "--overwrite")
    identify = ("identify", "arm.toml", "log.csv", "-o", "out.toml", "--overwrite", "--force")
    for words, output in ((simulate, "log.csv"), (identify, "out.toml")):
        both = [started(*words), started(*words)]
        said = [run.communicate(timeout=PATIENCE) for run in both]
        assert [run.returncode for run in both] == [0, 0], said
        content = (place / output).read_bytes()
        alone = started(*words)
        alone.communicate(timeout=PATIENCE)
        assert (place / output).read_bytes() == content
    assert list((place / "cache").rglob("*.*"))
    assert [file for file in place.iterdir() if file.name.startswith(".")] == []
    assert emptied(place / "temporary") == []
