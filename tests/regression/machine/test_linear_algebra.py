"""BLAS takes one thread while a verb works, and as many as before when the last verb has ended."""

import re
import threading

import pytest
import scipy.linalg  # noqa: F401  (has a BLAS of its own)
from threadpoolctl import threadpool_info, threadpool_limits

import pyident as pi
from pyident.refinement.identifications import IDENTIFICATIONS
from pyident.regression.machine.linear_algebra import one_thread


def threads() -> set[int]:
    """Of NumPy's and SciPy's BLAS; a solver may load one of its own later."""
    loaded = [pool for pool in threadpool_info() if pool["user_api"] == "blas"]
    return {pool["num_threads"] for pool in loaded if re.search("numpy|scipy", pool["filepath"])}


@pytest.fixture(autouse=True)
def two():
    with threadpool_limits(2):
        if threads() != {2}:
            pytest.skip("this BLAS takes one thread anyway")
        yield


def test_one_within_and_as_before_after_it():
    with one_thread():
        with one_thread():
            assert threads() == {1}
        assert threads() == {1}
    assert threads() == {2}


def test_as_before_after_a_failure():
    with pytest.raises(ValueError, match="no"), one_thread():
        raise ValueError("no")
    assert threads() == {2}


def test_the_limit_stays_until_the_last_has_ended():
    entered, left = threading.Event(), threading.Event()

    @one_thread()
    def other():
        entered.set()

    def work():
        other()
        left.set()

    with one_thread():
        threading.Thread(target=work).start()
        assert left.wait(10)
        assert entered.is_set()
        assert threads() == {1}
    assert threads() == {2}


def test_identify_works_in_one(monkeypatch, four_link, identification_log):
    seen: list[set[int]] = []
    plain = IDENTIFICATIONS["wls"]

    def watched(*arguments):
        seen.append(threads())
        return plain(*arguments)

    monkeypatch.setitem(IDENTIFICATIONS, "wls", watched)
    pi.identify(four_link, identification_log, estimator="wls")
    assert seen == [{1}]
    assert threads() == {2}
