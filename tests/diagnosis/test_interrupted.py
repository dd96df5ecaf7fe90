"""A diagnosis that somebody interrupts keeps its verdict and says what it did not look at."""

from dataclasses import replace

from pyident.diagnosis.diagnose import _as_far_as
from pyident.diagnosis.result import Diagnosis


def found() -> Diagnosis:
    return Diagnosis("arm", (), (), "unexplained", "Something.", (), None, (), (), 4.0, 4.0, ())


def interrupted(_):
    raise KeyboardInterrupt


def never(_):
    raise AssertionError("what comes after an interrupt is not begun")


def test_what_is_known_by_then_is_kept():
    def first(d):
        return replace(d, depends_on=("joint 1: time",))

    kept = _as_far_as(found(), [("leads", first), ("rivals", interrupted), ("motions", never)])
    assert kept.verdict == "unexplained"
    assert kept.depends_on == ("joint 1: time",)
    assert kept.notes == ("interrupted; not looked at: rivals, motions",)


def test_a_diagnosis_that_nobody_interrupts_has_no_such_note():
    assert _as_far_as(found(), [("leads", lambda d: d)]).notes == ()
