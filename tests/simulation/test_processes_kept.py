"""Processes that serve one pool after another, each with its own tool."""

import os
import sys
import time
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial

from pyident.simulation.processes import this_machine
from pyident.simulation.processes.this_machine import local_processes, processes_kept, processes_ready


@contextmanager
def tool(number):
    yield number


def process_and_tool(number):
    return os.getpid(), number


def imported(_, module):
    return module in sys.modules


def tools_held(_):
    from pyident.simulation.processes import tools

    return len(tools._tools)


def late(_):
    time.sleep(0.3)


def asked(number, work=process_and_tool, times=6):
    with local_processes(partial(tool, number)) as workers:
        return [job.result() for job in [workers.submit(work) for _ in range(times)]]


def test_one_pool_after_another_has_the_same_processes_and_a_tool_of_its_own():
    with processes_kept():
        first, second = asked(1), asked(2)
        assert max(asked(3, tools_held)) == 1  # those of the pools before are put away
    assert {number for _, number in first} == {1}
    assert {number for _, number in second} == {2}
    assert len({process for process, _ in first + second}) <= (os.cpu_count() or 1)


def test_without_it_each_pool_has_its_own():
    assert not {process for process, _ in asked(1)} & {process for process, _ in asked(2)}
    assert this_machine._kept.get() is None


def test_they_prepare_themselves_while_their_caller_goes_on():
    with processes_kept("sched"):
        assert not processes_ready()
        with local_processes(partial(tool, 1)) as workers:
            assert workers.submit(imported, "sched").result()
            assert not workers.submit(imported, "chunk").result()
        end = time.monotonic() + 60
        while not processes_ready() and time.monotonic() < end:
            time.sleep(0.05)  # the other one may still be starting
        assert processes_ready()
    assert not processes_ready()


def test_a_pool_that_is_left_cancels_its_own_tasks_only():
    with processes_kept(), local_processes(partial(tool, 1)) as outer:
        other: list[Future] = []
        with local_processes(partial(tool, 2)) as inner:
            queued = [inner.submit(late) for _ in range(40)]
            other.append(outer.submit(process_and_tool))
        assert any(job.cancelled() for job in queued)
        assert other[0].result()[1] == 1
