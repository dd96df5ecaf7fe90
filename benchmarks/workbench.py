"""How long the workbench lets one wait, as a browser sees it, and the memory of its server.

    python -m benchmarks.workbench -o out

A project with three logs of 20 s of four_link with a hidden law, made by studies/hidden_effect; Chromium
drives the page. Times are wall times from the click to the picture, so run it on a quiet machine, and beside
them the CPU seconds of the server and its jobs; the load of the machine stands in the table. Needs playwright
and Chromium (name it in CHROMIUM).
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
import pandas as pd
from benchmarks.measure import ROOT

from flexmodels.files.robot_file import shipped

GOALS = {
    "first paint": 1.5,
    "one hour at 1 kHz plotted": 5.0,
    "and zoomed": 0.2,
    "click on a bump": 0.3,
    "Try": 0.3,
    "Add": 20.0,
    "diagnosis of three logs of 20 s": 40.0,
    "memory of the server [MB]": 800.0,
}
LAW = "asymmetric_coulomb"
_LONG = 3_600_000  # samples of the long log
_PATIENCE = 300_000  # ms


def project(folder: Path) -> None:
    """A robot file, three logs with a hidden law, and a log of one hour that is left out."""
    made = folder / "made"
    words = ["-m", "studies.hidden_effect.generator", "--seed", "3", "--cases", LAW, "-o", str(made)]
    subprocess.run([sys.executable, *words], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    for log in (made / "logs").rglob("*.parquet"):
        shutil.move(log, folder / log.name)
    shutil.rmtree(made)
    shutil.copy(shipped()["four_link"], folder / "robot.toml")
    time = np.arange(_LONG) * 1e-3
    wave = np.sin(0.7 * time)
    pd.DataFrame({"time": time, **{f"joint{k}.e": wave * k for k in range(1, 5)}}).to_parquet(
        folder / "z.parquet"
    )


@contextmanager
def served(folder: Path) -> Iterator[tuple[str, int]]:
    """URL and process of a workbench."""
    words = [sys.executable, "-m", "pyident", "open", str(folder), "--no-browser"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield next(m[0] for line in process.stdout if (m := re.search(r"http://\S+", line))), process.pid
    finally:
        process.terminate()
        process.wait(30)


def cpu(pid: int) -> float:
    """Seconds of a process and of all that it started, over or not; NaN where the system does not say."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        listed = [file.read_text().split() for file in Path(f"/proc/{pid}/task").glob("*/children")]
    except OSError:
        return float("nan")
    own = sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    return own + float(np.nansum([cpu(int(child)) for children in listed for child in children]))


def measured(tab, url: str, pid: int) -> Iterator[tuple[str, tuple[float, float]]]:
    """Every wait of the loop, in its order: wall and CPU seconds of the server."""

    def seconds(action: Callable[[], object], until: Callable[[], object]) -> tuple[float, float]:
        """From before the action until what is waited for is there."""
        begin, used = perf_counter(), cpu(pid)
        action()
        until()
        return perf_counter() - begin, cpu(pid) - used

    by = tab.get_by_test_id
    drawn = "([id, n]) => document.querySelector(`[data-testid=${id}]`)?.data?.length >= n"

    def there(name: str):
        return lambda: by(name).first.wait_for(timeout=_PATIENCE)

    def ticks() -> list[float]:
        return tab.evaluate("document.querySelector('[data-testid=channels]').data[0].x.slice(0, 2)")

    yield "first paint", seconds(lambda: tab.goto(url), there("check"))
    plotted = partial(tab.wait_for_function, drawn, timeout=_PATIENCE)
    yield "one hour at 1 kHz plotted", seconds(by("look-3").click, lambda: plotted(arg=["channels", 4]))
    whole = ticks()
    yield (
        "and zoomed",
        seconds(
            lambda: tab.evaluate(ZOOM),
            lambda: tab.wait_for_function(
                "old => document.querySelector('[data-testid=channels]').data[0].x[1] !== old", arg=whole[1]
            ),
        ),
    )
    by("role-3").get_by_text("leave out").click()
    tab.wait_for_timeout(1000)  # the choice draws the place anew: a click at once would meet the old button
    by("check").click()
    there("sound")()
    by("place-where").click()
    yield "comparison", seconds(by("compare").click, there("where-sentence"))
    yield (
        "every law asked",
        seconds(lambda: None, lambda: by("job-ask").wait_for(state="detached", timeout=_PATIENCE)),
    )
    tab.wait_for_timeout(1000)  # the end of a job draws the place anew, and nobody clicks in that moment
    yield "click on a bump", seconds(by("bump-1").click, there("whole"))
    by("to-why").click()
    there("law-1")()
    yield "Try", seconds(by("try-1").click, lambda: tab.wait_for_function(drawn, arg=["waveform", 4]))
    yield "diagnosis of three logs of 20 s", seconds(by("diagnose").click, there("sentence"))
    yield "Add", seconds(by("law-add-1").click, there("outcome"))


ZOOM = """() => import("nicegui-plotly").then(({ Plotly }) => Plotly.relayout(
  document.querySelector('[data-testid=channels]'), {"xaxis.range[0]": 600, "xaxis.range[1]": 660}))"""


def peak(pid: int) -> float:
    """Of a process [MB]; NaN where the system does not say."""
    status = Path(f"/proc/{pid}/status")
    if not status.exists():
        return float("nan")
    return next(int(x.split()[1]) for x in status.read_text().splitlines() if x.startswith("VmHWM")) / 1e3


def run(folder: Path) -> pd.DataFrame:
    """What was measured, beside its goal."""
    from playwright.sync_api import sync_playwright

    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    project(folder)
    with served(folder) as (url, pid), sync_playwright() as tools:
        browser = tools.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1400, "height": 1000})
        rows = [(what, *values, GOALS.get(what)) for what, values in measured(tab, url, pid)]
        rows.append(("memory of the server [MB]", peak(pid), nan, GOALS["memory of the server [MB]"]))
        browser.close()
    rows.append(("load of the machine at the start", load, nan, None))
    return pd.DataFrame(rows, columns=["what", "seconds", "CPU seconds", "goal"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # pyright: ignore[reportOptionalMemberAccess]
    parser.add_argument("-o", "--out", type=Path, default=Path("out/bench"), help="folder of the results")
    arguments = parser.parse_args()
    with TemporaryDirectory() as folder:
        found = run(Path(folder))
    arguments.out.mkdir(parents=True, exist_ok=True)
    found.to_csv(arguments.out / "workbench.csv", index=False)
    print(found.to_string(index=False, float_format="%.2f", na_rep=""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
