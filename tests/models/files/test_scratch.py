"""Temporary folders of threads that all begin at once."""

import subprocess
import sys

import pytest

BEGIN_AT_ONCE = """
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from flexmodels.scratch import scratch_folder

together = Barrier(8)

def used(_):
    together.wait()
    with scratch_folder() as folder:
        assert folder.is_dir()
        return folder.parent

with ThreadPoolExecutor(8) as threads:
    roots = set(threads.map(used, range(8)))
print(len(roots), *(root.exists() for root in roots))
"""


@pytest.mark.parametrize("again", range(5))
def test_threads_that_begin_at_once_share_one_folder_of_their_process(again):
    done = subprocess.run([sys.executable, "-c", BEGIN_AT_ONCE], capture_output=True, text=True, check=True)
    assert (done.stdout.split(), done.stderr) == (["1", "True"], "")
