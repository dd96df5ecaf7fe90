"""Parts of work in threads: their order, their progress, and that they end together."""

from threading import Event

import pytest

from flexfmu.batch.side_by_side import Stopped, in_threads


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr("flexmodels.threads.cores", lambda: 2)


def test_answers_come_in_the_order_of_the_parts_and_progress_never_falls():
    told: list[float] = []

    def work(part, progress):
        for i, _ in enumerate(part, start=1):
            progress(i / len(part))
        return sum(part)

    assert in_threads(work, [[1, 2, 3], [4], [5, 6]], told.append) == [6, 4, 11]
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1.0)


def test_when_one_part_fails_the_others_are_stopped():
    begun, ended = Event(), Event()

    def work(part, progress):
        if part[0] == 0:
            begun.wait(10)
            raise ValueError("lost")
        begun.set()
        try:
            while True:
                progress(0.5)
        except Stopped:
            ended.set()
            raise

    with pytest.raises(ValueError, match="lost"):
        in_threads(work, [[0], [1]], lambda _: None)
    assert ended.is_set()


def test_an_interrupt_in_the_caller_s_progress_ends_every_part():
    def work(part, progress):
        while True:
            progress(0.5)

    def interrupted(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        in_threads(work, [[0], [1], [2]], interrupted)
