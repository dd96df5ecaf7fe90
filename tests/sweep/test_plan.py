"""Plan files: shares and patterns, designs, and what a wrong plan is told."""

import pytest

from flexmodels.files.robot_file import load_robot
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
    ],
)
def test_wrong_plans(plan_of, text, said):
    with pytest.raises(StudyError, match=said):
        plan_of(text)
