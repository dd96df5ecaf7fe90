"""Every defect is put into a sound log and must be named; sound logs must pass."""

import re
from dataclasses import replace

import numpy as np
import pytest

from flexmodels.files.robot_file import load_robot
from pyident.checks import timing
from pyident.checks.balances import balances, samples
from pyident.checks.check_log import check_log, checked
from pyident.checks.scale import file_factor
from pyident.checks.timing import common_delay, energies
from pyident.logs.disk import log_file
from pyident.logs.log import Log, LogError, read_log, write_log


@pytest.fixture(scope="module")
def sound(identification_log):
    """With a sensor's noise, so that no value repeats itself by computation alone."""
    rng, frame = np.random.default_rng(0), identification_log.frame.copy()
    for name in frame:
        if name.split(".")[-1].startswith(("e", "eps")):
            frame[name] += rng.normal(0, 2e-6 if name.endswith(".e") else 1e-6, len(frame))
    return Log(frame, "log.csv")


def changed(log: Log, **columns) -> Log:
    frame = log.frame.copy()
    for name, change in columns.items():
        name = name.replace("_", ".")
        frame[name] = change(frame[name].to_numpy(float).copy())
    return replace(log, frame=frame)


def with_jump(x):
    x[2000:] += 3e-3
    return x


def wrapped(x):
    x += 2.0
    return np.mod(x + np.pi, 2 * np.pi) - np.pi


def stuck(x):
    x[3000:3060] = x[3000]
    return x


def slowly(x):
    return np.repeat(x[::4], 4)[: len(x)]


def limited(x):
    return np.clip(x, *(0.6 * np.array([x.min(), x.max()])))


def test_sound_logs_have_no_defect(four_link, identification_log, sound):
    assert check_log(four_link, sound) == ()
    assert check_log(four_link, identification_log) == ()


def test_a_measured_log_has_no_defect(data):
    robot = load_robot("emps")
    assert check_log(robot, read_log(data / "emps/DATA_EMPS.mat", robot.settings.columns)) == ()


@pytest.mark.parametrize(
    ("change", "severity", "words"),
    [
        ({"joint2_tau": limited}, "doubtful", "joint2.tau stands at"),
        ({"joint3_e": with_jump}, "doubtful", "joint3.e jumps by 0.003"),
        ({"joint1_e": wrapped}, "gross", "joint1.e jumps by a turn"),
        ({"joint2_e": stuck}, "gross", "joint2.e is stuck"),
        ({"joint4_eps[2]": lambda x: 0 * x}, "gross", "joint4.eps[2] is 0 throughout"),
        ({"joint1_tau": slowly}, "doubtful", "joint1.tau changes only every 4th sample"),
        ({"joint2_e": lambda x: np.round(x / 2e-3) * 2e-3}, "doubtful", "joint2.e comes in steps of 0.002"),
        ({"joint3_tau": lambda x: -x}, "gross", "joint3.tau"),
        ({"joint2_e": lambda x: -x}, "gross", "joint2.e"),
        ({"joint1_eps[1]": lambda x: -x}, "gross", "joint1.eps[1] has the wrong sign"),
        ({"joint1_eps[1]": lambda x: 1e3 * x}, "gross", "joint1.eps[1] gives a stiffness 0.0"),
        ({"joint2_tau": lambda x: np.roll(x, -2)}, "doubtful", "joint2.tau is 2 samples (8 ms) early"),
        ({"joint1_tau": lambda x: np.roll(x, 12)}, "gross", "joint1.tau is 12 samples (48 ms) late"),
        ({"time": lambda t: 1e3 * t}, "gross", "check the unit of time"),
        ({"joint3_e": lambda x: np.linspace(0, 2, len(x))}, "gross", "joint3.e grows evenly with time"),
        ({"joint2_e": lambda x: 1e3 * x}, "gross", "check its unit"),
        ({"joint2_tau": np.abs}, "doubtful", "it looks like a magnitude"),
        (
            {"time": lambda t: t + 0.02 * np.sin(2 * np.pi * t / t[-1])},
            "doubtful",
            "the clock drifts",
        ),
    ],
)
def test_a_defect_is_named(four_link, sound, change, severity, words):
    found = check_log(four_link, changed(sound, **change))
    assert any(words in d.sentence and d.severity == severity for d in found), found
    assert all(d.sentence.startswith("log.csv: ") for d in found)


def test_doubled_rows_are_named(four_link, sound):
    at = np.arange(len(sound))
    at[[500, 900, 1400, 2000]] -= 1
    frame = sound.frame.iloc[at].reset_index(drop=True)
    frame["time"] = sound.frame["time"]
    assert any("recorded twice" in d.sentence for d in check_log(four_link, replace(sound, frame=frame)))


def test_rows_out_of_order_are_named(four_link, sound):
    frame = sound.frame.sample(frac=1, random_state=3).reset_index(drop=True)
    frame["time"] = sound.frame["time"]
    assert any("out of order" in d.sentence for d in check_log(four_link, replace(sound, frame=frame)))


@pytest.mark.parametrize(
    ("name", "other", "words"),
    [
        ("joint2.e", "joint1.e", "joint1.e and joint2.e are the same numbers"),
        ("joint2.e", "joint2.r", "the reference stands where the measured position should"),
    ],
)
def test_a_column_that_stands_twice_is_named(four_link, sound, name, other, words):
    twice = replace(sound, frame=sound.frame.assign(**{name: sound.frame[other]}))
    found = [d for d in check_log(four_link, twice) if words in d.sentence]
    assert [d.severity for d in found] == ["gross"]


@pytest.mark.parametrize("shift", [-1.0, 3.5])
def test_a_torque_between_samples_is_placed(four_link, sound, shift):
    """The torque moved by the Fourier shift theorem, which the check does not use."""
    tau = sound.frame["joint3.tau"].to_numpy(float)
    spectrum = np.fft.rfft(tau) * np.exp(-2j * np.pi * np.fft.rfftfreq(len(tau)) * shift)
    moved = changed(sound, joint3_tau=lambda _: np.fft.irfft(spectrum, len(tau)))
    shifts = np.arange(-8, 9) / 2
    of = balances(samples(four_link, moved))  # pyright: ignore[reportArgumentType]
    assert shifts[np.argmin(energies(of, 2, shifts))] == shift
    assert shifts[np.argmin(energies(of, 0, shifts))] == 0


@pytest.mark.parametrize("late", [0, 1, 2])
def test_what_delays_all_torques_alike_is_measured(four_link, sound, late):
    """As by a recorder that reads before it steps; the standard deviation covers the truth."""
    torques = {f"joint{k}_tau": lambda x: np.roll(x, late) for k in (1, 2, 3, 4)}
    moved = changed(sound, **torques)
    delay = common_delay(balances(samples(four_link, moved)))  # pyright: ignore[reportArgumentType]
    assert delay is not None
    assert delay.std < 0.1
    assert abs(delay.shift - late) < 3 * delay.std
    assert {d.kind for d in check_log(four_link, moved)} == ({"delay"} if late else set())


def test_degrees_are_told_as_such_and_not_as_wrong_signs(four_link, sound):
    moved = changed(sound, **{f"joint{k}_e": np.degrees for k in (1, 2, 3, 4)})
    found = check_log(four_link, moved)
    assert {d.kind for d in found if d.severity == "gross"} == {"unit"}
    assert "sign" not in {d.kind for d in found}


def test_torques_that_are_far_late_alike_are_one_defect(four_link, sound):
    """Each by itself would be told as late, too, and by another amount."""
    moved = changed(sound, **{f"joint{k}_tau": lambda x: np.roll(x, 5) for k in (1, 2, 3, 4)})
    (found,) = [d for d in check_log(four_link, moved) if d.kind == "delay"]
    size = re.search(r"all torques are ([\d.]+) ± ([\d.]+) samples late", found.sentence)
    assert size is not None
    assert abs(float(size[1]) - 5) < 3 * float(size[2]) < 1
    one = changed(sound, joint1_tau=lambda x: np.roll(x, 5))
    assert [d.channel for d in check_log(four_link, one) if d.kind == "delay"] == ["joint1.tau"]


@pytest.mark.parametrize(("late", "told"), [(1, False), (2, True)])
def test_one_recorder_delays_the_torques_of_most_logs(late, told, four_link, sound):
    """One of three that seems late is what the model lacks along its motion."""
    torques = {f"joint{k}_tau": lambda x: np.roll(x, 1) for k in (1, 2, 3, 4)}
    logs = [changed(sound, **torques)] * late + [sound] * (3 - late)
    named = [replace(log, source=f"log{i}.csv") for i, log in enumerate(logs)]
    found = checked(four_link, named).defects
    assert any("all torques" in d.sentence for d in found) == told


def test_what_delays_one_joint_is_no_recorder(four_link, sound):
    moved = changed(sound, joint1_tau=lambda x: np.roll(x, 2))
    assert common_delay(balances(samples(four_link, moved))) is None  # pyright: ignore[reportArgumentType]


def test_joints_that_differ_from_each_other_have_no_delay_in_common(monkeypatch, four_link, sound):
    """Each by itself may have the mean one, as their standard deviations are large."""
    signals = samples(four_link, sound)
    assert signals is not None
    of = balances(signals)
    told = dict(zip(of.joints, [(-0.4, 0.3), (-2.2, 0.2), (-1.3, 0.1), (-1.3, 0.1)], strict=True))
    monkeypatch.setattr(timing, "_vertex", lambda _, k, __: timing.CommonDelay(*told[k]))
    assert common_delay(of) is None
    told[of.joints[1]] = (-1.2, 0.2)
    assert common_delay(of) is not None
    monkeypatch.setattr(timing, "energies", lambda *_: np.array([1.0, 0.9]))
    assert not list(timing.all_late(of, "log"))  # a ripple, of which any shift takes a little
    monkeypatch.setattr(timing, "energies", lambda *_: np.array([1.0, 0.5]))
    (early,) = timing.all_late(of, "log")
    assert "samples early; positions behind a filter" in early.sentence
    assert "move the columns of the positions" in early.sentence


def test_the_robot_file_is_a_witness_of_size_alone(four_link, sound):
    """Masses of the file a quarter off are no reason to complain; torques in N cm are."""
    heavier = {name: 1.25 * v for name, v in four_link.parameters.items() if name.startswith("link")}
    other = four_link.with_parameters(heavier)
    assert check_log(other, sound) == ()
    assert file_factor(balances(samples(four_link, sound))) == pytest.approx(1, abs=0.05)  # pyright: ignore[reportArgumentType]
    torques = {f"joint{k}_tau": lambda x: 100 * x for k in (1, 2, 3, 4)}
    assert file_factor(balances(samples(four_link, changed(sound, **torques)))) == pytest.approx(  # pyright: ignore[reportArgumentType]
        100, rel=0.05
    )


def test_a_log_without_torques_is_judged_by_its_motion(four_link, sound):
    bare = replace(sound, frame=sound.frame.drop(columns=[n for n in sound.names if n.endswith("tau")]))
    assert check_log(four_link, bare) == ()
    assert [d.kind for d in check_log(four_link, changed(bare, joint1_e=wrapped))] == ["wrapped"]


def test_an_axis_at_rest_is_not_stuck(four_link, sound):
    frame = sound.frame.assign(**{"joint4.e": 0.0, "joint4.eps[1]": 0.0, "joint4.tau": 0.0, "joint4.r": 0.0})
    frame = frame.assign(**{"joint4.eps[2]": 0.0, "joint4.eps[3]": 0.0})
    kinds = {d.kind for d in check_log(four_link, replace(sound, frame=frame))}
    assert not kinds & {"stuck", "constant"}
    first = changed(sound, joint4_e=lambda x: np.concatenate([np.full(500, x[0]), x[:-500]]))
    assert "stuck" not in {d.kind for d in check_log(four_link, first)}


def test_what_is_gross_is_refused_unless_forced(four_link, sound, tmp_path):
    wrong = changed(sound, joint3_tau=lambda x: -x)
    with pytest.raises(LogError, match=r"joint3\.tau.*--force") as refused:
        checked(four_link, [sound, wrong])
    assert "\n" not in str(refused.value)
    found = checked(four_link, [wrong], force=True)
    assert found.json()[0]["severity"] == "gross"
    assert found.warnings[0] == found.json()[0]["sentence"]
    write_log(wrong, tmp_path / "wrong.csv")
    with pytest.raises(LogError, match=r"wrong\.csv: .*joint3\.tau"):
        checked(four_link, [log_file(tmp_path / "wrong.csv")])


def test_a_refusal_says_that_the_log_has_more_joints(four_link, sound):
    """A longer arm's log: whatever seems wrong of it, that is the reason to look at first."""
    frame = sound.frame.assign(
        **{"joint5.e": sound.frame["joint1.e"] ** 2, "joint2.e": -sound.frame["joint2.e"]}
    )
    with pytest.raises(
        LogError, match=r"; robot four_link has 4 joints, and the log 5; .* this robot's log\?"
    ):
        checked(four_link, [replace(sound, frame=frame)])
