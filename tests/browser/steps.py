"""What journeys do on their way, and what they look at."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

Axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe

PATIENCE = 300_000  # ms that a journey waits for work on a busy machine
CURVES = "([id, n]) => document.querySelector(`[data-testid=${id}]`).data?.length === n"


def curves(tab, name: str) -> int:
    """How many curves a figure has, once it is drawn."""
    tab.wait_for_function("id => document.querySelector(`[data-testid=${id}]`)?.data", arg=name)
    return tab.evaluate("id => document.querySelector(`[data-testid=${id}]`).data.length", name)


def pictured(tab, name: str) -> None:
    """A picture of the page, where PICTURES names a folder for them."""
    if "PICTURES" in os.environ:
        tab.wait_for_timeout(1500)
        tab.screenshot(path=f"{os.environ['PICTURES']}/{name}.png", full_page=True)


def accessible(tab) -> None:
    """No violation that axe-core calls serious or critical."""
    results = Axe().run(tab).response["violations"]
    serious = [v for v in results if v["impact"] in ("serious", "critical")]
    words = [f"{v['id']}: {v['help']}: {[n['html'][:200] for n in v['nodes'][:3]]}" for v in serious]
    assert not words, "\n".join(words)


def compared(tab, url: str) -> None:
    """Check, compare, and wait until every law has been asked."""
    checked(tab, url)
    tab.get_by_test_id("place-where").click()
    tab.get_by_test_id("compare").click()
    tab.get_by_test_id("where-sentence").wait_for(timeout=PATIENCE)
    tab.get_by_test_id("job-ask").wait_for(state="detached", timeout=PATIENCE)
    curves(tab, "states")


def checked(tab, url: str) -> None:
    """Open the workbench and let it check the logs."""
    tab.goto(url)
    tab.get_by_test_id("check").click()
    tab.get_by_test_id("sound").wait_for(timeout=PATIENCE)


@contextmanager
def served(folder: Path, port: int = 0) -> Iterator[str]:
    """The URL of a workbench on the folder."""
    words = [sys.executable, "-m", "pyident", "open", str(folder), "--no-browser", "--port", str(port)]
    # NiceGUI behaves differently where it believes that it is under test
    plain = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "NICEGUI"))}
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=plain)
    try:
        assert process.stdout is not None
        url = next((m[0] for line in process.stdout if (m := re.search(r"http://\S+", line))), None)
        assert url, "the workbench printed no URL"
        yield url
    finally:
        process.terminate()
        process.wait(30)
        if process.stdout is not None:
            process.stdout.close()
