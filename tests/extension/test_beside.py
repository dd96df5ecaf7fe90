"""Work beside the caller's own: its result, its failure, the caller's context."""

from contextvars import ContextVar
from threading import Event

import pytest

from pyident.extension.beside import begun

told = ContextVar("told", default="nothing")


def test_work_goes_on_while_the_caller_does_and_sees_what_the_caller_set():
    caller_goes_on = Event()

    def work(word):
        assert caller_goes_on.wait(10)
        return word + told.get()

    token = told.set("well")
    future = begun(work, "all is ")
    told.reset(token)
    assert not future.done()
    caller_goes_on.set()
    assert future.result(10) == "all is well"


def test_who_asks_for_the_result_gets_the_failure():
    future = begun(int, "no number")
    with pytest.raises(ValueError, match="no number"):
        future.result(10)
