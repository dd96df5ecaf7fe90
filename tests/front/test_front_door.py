"""What `import pyident` offers, and that the command line offers the same."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from two_link_logs import two_link

import pyident as pi
from pyident.cli.main import COMMANDS, main

HEAVY = ("casadi", "cvxpy", "fmpy", "jinja2", "matplotlib", "numpy", "pandas", "plotly", "scipy", "sympy")


def test_every_name_of_the_front_door_is_there():
    for name in pi.__all__:
        assert getattr(pi, name) is not None
    with pytest.raises(AttributeError, match=r"pyident has no identity; it has .*identify"):
        _ = pi.identity  # pyright: ignore


def asks(*words: str) -> str:
    return f"from pyident.cli.main import main; main({[*words, '--help']!r})"


@pytest.mark.parametrize("code", ["import pyident", asks(), *map(asks, COMMANDS)])
def test_neither_import_nor_help_loads_a_heavy_library(code):
    after = f"import atexit, sys\natexit.register(lambda: print('loaded', *sys.modules))\n{code}"
    run = subprocess.run([sys.executable, "-c", after], capture_output=True, text=True, check=True)
    loaded = set(run.stdout.splitlines()[-1].split())
    assert "pyident" in loaded
    assert not loaded & {*HEAVY, "flexmodels.robot", "flexfmu.build"}


@pytest.mark.parametrize("name", COMMANDS)
def test_the_short_help_of_a_command_is_the_start_of_its_own(name):
    shown = CliRunner().invoke(main, [name, "--help"])
    assert shown.exit_code == 0, shown.output
    assert COMMANDS[name].help.rstrip(".") in " ".join(shown.output.split())
    assert max(map(len, shown.output.splitlines())) <= 80, "too wide for a terminal"
    assert name in CliRunner().invoke(main, ["--help"]).output


def frame(rows: int = 400) -> pd.DataFrame:
    """A motion of the two-link robot without a meaning, but with every column."""
    time = np.arange(rows) / 100
    names = [*two_link().coordinates, *two_link().torques]
    return pd.DataFrame({"time": time} | {n: np.sin((1 + i) * time) for i, n in enumerate(names)})


@pytest.mark.parametrize("make", [pi.Log, pi.Log.from_frame])
def test_a_frame_is_checked_when_it_becomes_a_log(make):
    good = frame()
    assert make(good).period == pytest.approx(0.01)
    with pytest.raises(pi.LogError, match=r"time goes from"):
        make(good.assign(time=good["time"] ** 1.2))
    holed = good.copy()
    holed.loc[99, "joint1.e"] = np.nan
    where = r"joint1\.e is not finite in 1 rows, first in row 100 \(time 0.99 s\)"
    with pytest.raises(pi.LogError, match=where):
        make(holed)
    with pytest.raises(pi.LogError, match=where):
        replace(make(good), frame=holed)


@pytest.mark.parametrize("verb", [pi.identify, pi.compare, pi.diagnose])
def test_a_frame_that_never_was_a_log_is_checked_by_every_verb(verb):
    holed = frame()
    holed.loc[99, "joint1.e"] = np.nan
    spoilt = pi.Log(frame())
    spoilt.frame.loc[99, "joint1.e"] = np.nan  # after it was checked
    for given in (holed, spoilt, [pi.Log(frame()), holed]):
        with pytest.raises(pi.LogError, match="row 100"):
            verb(two_link(), given)


def test_no_log_is_said_so():
    with pytest.raises(pi.LogError, match="there is no log"):
        pi.identify(two_link(), [])


def test_a_value_that_is_no_number_is_refused():
    for text in ("joint1.coulomb", "joint1.coulomb=much", "joint1.coulomb=nan", "=3"):
        run = CliRunner().invoke(
            main, ["simulate", "four_link", "--experiment", "line", "-o", "x.csv", "--set", text]
        )
        assert run.exit_code == 2
        assert "NAME=VALUE" in run.output


def test_an_unknown_parameter_is_refused_by_its_name():
    with pytest.raises(pi.RobotError, match=r"no parameter joint1\.nonsense"):
        pi.simulate("four_link", "line", parameters={"joint1.nonsense": 1.0})
