"""Processes for a script that has no `if __name__ == "__main__":`, as most scripts have none."""

import subprocess
import sys

from pyident.simulation.processes.process_ends import not_run_again

SCRIPT = """
from functools import partial
from contextlib import nullcontext
from pyident.simulation.processes.this_machine import local_processes

print("running")
with local_processes(partial(nullcontext, 7)) as workers:
    print([workers.submit(pow, number).result() for number in (2, 3)])
"""


def test_a_script_without_a_guard_runs_once(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n", 1) == ["running", "[49, 343]\n"]


def test_the_script_is_known_again_afterwards():
    main = sys.modules["__main__"]
    before = main.__spec__, getattr(main, "__file__", None)
    with not_run_again():
        assert main.__spec__ is None
    assert (main.__spec__, getattr(main, "__file__", None)) == before
