"""What a file sees of long work."""

import time

import pytest

from pyident.cli.common.progress import SECONDS, lines, repeated


def test_a_line_every_ten_seconds_with_what_is_left(capsys):
    now = [0.0]
    progress = lines("search", lambda: now[0])
    for second in range(1, 41):
        now[0] = float(second)
        progress(second / 80)
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 40 / SECONDS
    assert said[:2] == ["search: 12 % after 10 s", "search: 25 % after 20 s, about 60 s left"]
    assert said[-1] == "search: 50 % after 40 s, about 40 s left"


def test_what_came_before_the_first_share_is_not_extrapolated(capsys):
    """20 s of preparation, then 1 % a second: at first too little is done to tell."""
    now = [0.0]
    progress = lines("search", lambda: now[0])
    for second in range(20, 51):
        now[0] = float(second)
        progress((second - 19) / 100)
    said = capsys.readouterr().err.splitlines()
    assert said == [
        "search: 1 % after 20 s",
        "search: 11 % after 30 s",
        "search: 21 % after 40 s",
        "search: 31 % after 50 s, about 69 s left",
    ]


def test_a_first_share_that_is_large_tells_the_rest(capsys):
    now = [0.0]
    progress = lines("fit", lambda: now[0])
    now[0] = 20.0
    progress(0.25)
    assert capsys.readouterr().err.splitlines() == ["fit: 25 % after 20 s, about 60 s left"]


def test_a_step_that_lasts_makes_the_rest_shorter_until_nothing_is_known_of_it(capsys):
    now = [0.0]
    progress = lines("search", lambda: now[0])
    for second in range(1, 61):
        now[0] = float(second)
        progress(min(second / 40, 0.5))
    said = capsys.readouterr().err.splitlines()
    assert said[1:] == [
        "search: 50 % after 20 s, about 20 s left",
        "search: 50 % after 30 s, about 10 s left",
        "search: 50 % after 40 s, about 0 s left",
        "search: 50 % after 50 s",
        "search: 50 % after 60 s",
    ]


def test_a_long_step_is_not_silent(capsys):
    """One call in fifty seconds of a clock that runs a thousand times as fast."""
    begin = time.monotonic()
    with repeated(lines("fit", lambda: 1000 * (time.monotonic() - begin)), every=0.001) as progress:
        progress(0.5)
        time.sleep(0.05)
    said = capsys.readouterr().err.splitlines()
    assert len(said) >= 3
    assert all(line.startswith("fit: 50 % after ") for line in said)
    time.sleep(0.02)
    assert capsys.readouterr().err == ""  # nothing after the end


def failing(said: list[float]) -> None:
    with repeated(said.append, every=0.001) as progress:
        progress(0.25)
        time.sleep(0.02)
        raise ValueError("no")


def test_work_that_fails_ends_its_progress():
    said: list[float] = []
    with pytest.raises(ValueError, match="no"):
        failing(said)
    count = len(said)
    assert count > 1
    time.sleep(0.02)
    assert len(said) == count
    assert set(said) == {0.25}
