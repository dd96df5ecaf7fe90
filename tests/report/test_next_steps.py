"""The commands that a diagnosis leads to run as they stand."""

from dataclasses import replace

from pyident.diagnosis.result import Diagnosis, Finding, Named
from pyident.report.next_steps import commands


def law(effect: str, joint: int, log: str | None = None) -> Named:
    return Named(effect, f"joint{joint}", {}, {}, {}, 50.0, log)


def finding(*tie: Named) -> Finding:
    return Finding(tie, 0.05, 50.0, 50.0, None)


MISSING = Diagnosis(
    robot="arm",
    logs=("a log.csv", "b.csv"),
    heldout=("c.csv",),
    verdict="missing_effect",
    sentence="",
    findings=(finding(law("stribeck", 2)), finding(law("payload", 3, "b.csv")), finding(law("stribeck", 2))),
    localised=None,
    limits=(),
    rows=(),
    excess=2.0,
    remaining=1.0,
    ranking=(),
    notes=(),
    noise={},
    stages=(),
)


def test_laws_are_added_one_after_the_other_each_once():
    ((heading, lines),) = commands(MISSING, "my/arm.toml")
    assert heading.startswith("Add it and fit again")
    assert lines == [
        "pyident add my/arm.toml stribeck --joint 2 'a log.csv' --holdout c.csv -o arm_stribeck.toml",
        "pyident identify arm_stribeck.toml 'a log.csv' -o arm_stribeck_empty.toml",
        "pyident payload arm_stribeck_empty.toml 'a log.csv' b.csv -o arm_stribeck_b.toml",
        "pyident diagnose arm_stribeck.toml 'a log.csv' --holdout c.csv",
    ]


def test_no_command_speaks_of_a_load_that_is_taken_up_within_a_log():
    within = replace(MISSING, findings=(finding(law("payload", 3, "b.csv from 9.008 s on")),))
    ((_, lines),) = commands(within, "arm.toml")
    assert lines == ["pyident diagnose arm.toml 'a log.csv' --holdout c.csv"]


def test_of_one_log_its_last_part_is_held_out_again():
    """Held out as a whole it would be judged by what it was fitted to."""
    alone = replace(MISSING, logs=("a.csv",), heldout=("a.csv",), findings=MISSING.findings[:1])
    ((_, lines),) = commands(alone, "arm.toml")
    assert lines == [
        "pyident add arm.toml stribeck --joint 2 a.csv -o arm_stribeck.toml",
        "pyident diagnose arm_stribeck.toml a.csv",
    ]


def test_a_tie_leads_to_a_way_for_each_of_its_laws():
    tie = replace(
        MISSING,
        verdict="cannot_tell",
        findings=(finding(law("stribeck", 1), law("presliding", 1)), finding(law("payload", 3))),
    )
    ways = commands(tie, "arm.toml")
    assert [heading for heading, _ in ways] == [
        "If it is stribeck at joint1",
        "If it is presliding at joint1",
    ]
    assert all(len(lines) == 3 and "payload" in lines[1] for _, lines in ways)


def test_a_robot_file_is_corrected_and_a_gain_of_torque_is_none_of_its_words():
    wrong = replace(MISSING, findings=(finding(law("origin[z]", 3)), finding(law("torque_gain", 1))))
    ((_, lines),) = commands(wrong, "arm.toml")
    assert lines == [
        "pyident add arm.toml geometry 'joint3.origin[z]' 'a log.csv' b.csv "
        "--holdout c.csv -o arm_geometry.toml",
        "pyident diagnose arm_geometry.toml 'a log.csv' b.csv --holdout c.csv",
    ]


def test_nothing_to_add_leads_nowhere():
    assert commands(replace(MISSING, verdict="unexplained", findings=()), "arm.toml") == []
