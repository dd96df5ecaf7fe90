"""Plan files: shares and patterns, designs, and what a wrong plan is told."""

import pandas as pd
import pytest
from one_joint import one_joint, swing

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.sweep.cost import in_words
from pyident.sweep.plan import load_study_plan
from pyident.sweep.store import StudyError

HEAD = 'model = "four_link"\nexperiment = "identification"\n'


@pytest.fixture(scope="module")
def plan_of(tmp_path_factory):
    def write(text):
        file = tmp_path_factory.mktemp("plan") / "plan.toml"
        file.write_text(HEAD + text)
        return load_study_plan(file)

    return write


def test_a_share_is_of_the_robots_own_value(plan_of):
    plan = plan_of('design = "latin_hypercube"\nruns = 8\n[parameters]\n"joint*.k[1]" = 0.25\n')
    own = load_robot("four_link").parameters
    assert set(plan.ranges) == {f"joint{k}.k[1]" for k in (1, 2, 3, 4)}
    for name, (low, high) in plan.ranges.items():
        assert (low, high) == pytest.approx((0.75 * own[name], 1.25 * own[name]))
        assert plan.design[name].between(low, high).all()
    assert len(plan.design) == 8


def test_a_latin_hypercube_has_one_run_in_every_stratum(plan_of):
    plan = plan_of('runs = 20\n[parameters]\n"joint1.coulomb" = [20.0, 40.0]\n')
    strata = ((plan.design["joint1.coulomb"] - 20.0) // 1.0).astype(int)
    assert sorted(strata) == list(range(20))


def test_a_grid_is_every_combination(plan_of):
    ranges = '"joint1.coulomb" = [20.0, 30.0, 40.0]\n"joint2.coulomb" = [1.0, 2.0]\n'
    plan = plan_of(f'design = "grid"\n[parameters]\n{ranges}')
    assert len(plan.design.drop_duplicates()) == 6
    assert plan.ranges["joint1.coulomb"] == (20.0, 40.0)


def test_the_same_seed_is_the_same_design(plan_of):
    text = 'runs = 5\nseed = {}\n[parameters]\n"joint1.coulomb" = 0.1\n'
    one, again, other = (plan_of(text.format(seed)).design for seed in (1, 1, 2))
    assert one.equals(again)
    assert not one.equals(other)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('design = "spiral"\n[parameters]\n"joint1.coulomb" = 0.1\n', "design is 'spiral'; known are grid"),
        ("[parameters]\n", "is empty; name at least one"),
        ('[parameters]\n"joint9.coulomb" = 0.1\n', "names no parameter of the robot"),
        ('[parameters]\n"joint1.coulomb" = [40.0, 20.0]\n', "must be \\[from, to\\] with from < to"),
        ('metrics = ["speed"]\n[parameters]\n"joint1.coulomb" = 0.1\n', "unknown metric 'speed'"),
        ('metrics = "tip"\n[parameters]\n"joint1.coulomb" = 0.1\n', "metrics must be a list of names"),
        ('metrics = [1]\n[parameters]\n"joint1.coulomb" = 0.1\n', "metrics must be a list of names"),
        (
            f'design = "grid"\n[parameters]\n"joint1.*" = {[*range(1, 40)]}\n',
            "runs, .* are the most; take fewer values",
        ),
    ],
)
def test_wrong_plans(plan_of, text, said):
    with pytest.raises(StudyError, match=said):
        plan_of(text)


def test_a_plan_of_an_fmu_states_its_own_ranges(tmp_path):
    """An FMU's file tells no values, so a share of them means nothing."""
    pi.export_fmu(one_joint(), tmp_path / "arm.fmu")
    pi.export_plan(swing(), one_joint(), tmp_path / "plan.csv")
    experiment = pd.DataFrame({"time": swing().time, "joint1.r": swing().reference[:, 0]})
    experiment.to_csv(tmp_path / "wish.csv", index=False)
    head = 'model = "arm.fmu"\nexperiment = "wish.csv"\nruns = 3\n[parameters]\n"joint1.coulomb" = '
    file = tmp_path / "study.toml"
    file.write_text(head + "[1.0, 2.0]\n")
    plan = load_study_plan(file)
    assert plan.ranges == {"joint1.coulomb": (1.0, 2.0)}
    with pytest.raises(StudyError, match="an FMU keeps its own values"):
        load_study_plan(file, {"joint1.coulomb": 1.0})
    file.write_text(head + "0.1\n")
    with pytest.raises(StudyError, match="is a share of a value that an FMU file does not state"):
        load_study_plan(file)


def test_a_metric_that_its_file_does_not_hold_is_refused(tmp_path):
    (tmp_path / "own.py").write_text("other = 3\n")
    (tmp_path / "broken.py").write_text("raise SystemExit(3)\n")
    text = '{}metrics = ["{}"]\n[parameters]\n"joint1.coulomb" = 0.1\n'
    for metric, said in (
        ("own.py:speed", "own.py has no function speed"),
        ("own.py:other", "own.py has no function other"),
        ("broken.py:f", r"broken\.py cannot be read \(SystemExit: 3\)"),
        ("own.txt:f", "give FILE.py:FUNCTION, or one of"),
    ):
        (tmp_path / "plan.toml").write_text(text.format(HEAD, metric))
        with pytest.raises(StudyError, match=said):
            load_study_plan(tmp_path / "plan.toml", allow_effects=True)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(3.2, "3 s"), (119.0, "119 s"), (150.0, "2 minutes"), (9_000.0, "2 hours"), (2e5, "2 days")],
)
def test_a_duration_is_said_as_one_says_it(seconds, words):
    assert in_words(seconds) == words
