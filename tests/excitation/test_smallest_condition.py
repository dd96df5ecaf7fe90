"""The smallest condition number by gradients: closed forms, differences, limits, and how far it comes."""

import numpy as np
import pytest
from planned_joint import limited
from two_link_logs import two_link

import pyident as pi
from flexmodels.files.robot_file import load_robot
from pyident.excitation.capsules import geometry_of
from pyident.excitation.design import best_conditioned
from pyident.excitation.drawing import Drawing
from pyident.excitation.followed import followed
from pyident.excitation.gradients.slopes import Setting
from pyident.excitation.gradients.smallest_condition import condition_number, smallest_condition
from pyident.excitation.limits import limits_of
from pyident.excitation.rehearsals.rehearsal import reference_of_plan, rehearsal
from pyident.excitation.rehearsals.violations import of_reference
from pyident.excitation.search import Budget
from pyident.excitation.task import Task
from pyident.regression.regressor import regressor


def task_of(robot, duration: float) -> Task:
    given = {
        f"joint{k}.{name}": value
        for k, joint in robot.numbered
        if joint.limits is None
        for name, value in (("lower", -1.0), ("upper", 1.0), ("speed", 2.0), ("torque", 90.0))
    }
    return Task(robot, limits_of(robot, given), geometry_of(robot, floor=None), {}, duration, 50.0)


def setting(robot, duration: float, columns) -> Setting:
    drawing = Drawing(task_of(robot, duration))
    return Setting(drawing, drawing.family.times(drawing.coarse), np.asarray(columns))


def offered(robot, duration: float, evaluations: int):
    task = task_of(robot, duration)
    with rehearsal(robot) as own:
        return task, best_conditioned(
            task, Drawing(task), own, Budget(evaluations, seconds=1000), lambda _: None
        )


def test_the_number_is_that_of_one_joint_in_closed_form():
    """Inertia, viscous and Coulomb friction: columns ddq, dq, sign(dq) of every sample."""
    robot = limited()
    names = list(robot.linear_parameters)
    found = setting(robot, 3.0, [names.index(f"joint1.{name}") for name in ("J_m", "viscous", "coulomb")])
    motion = found.motion(found.drawing.starts(1)[0])
    columns = np.hstack([motion[2], motion[1], np.sign(motion[1])])
    assert condition_number(found.samples(motion).matrix) == pytest.approx(np.linalg.cond(columns))


def test_changes_of_a_flexible_robot_are_those_of_its_regressor_and_limits():
    robot = two_link()
    found = setting(robot, 6.0, np.arange(len(robot.linear_parameters)))
    motion = found.motion(found.drawing.starts(1)[0])
    assert np.isfinite(found.drawing.torque).all()
    for i, k, slope in found.slopes(motion):
        near, far = motion.copy(), motion.copy()
        near[i, :, k] -= 1e-4
        far[i, :, k] += 1e-4
        sides = [followed(robot, found.time, *x) for x in (near, far)]
        Phi = [regressor(robot, side).matrix for side in sides]
        jumps = (np.sign(near[1]) != np.sign(far[1])).any(axis=1)  # of dry friction
        smooth = ~np.convolve(jumps, np.ones(5), "same").astype(bool)
        expected = ((Phi[1] - Phi[0]) / 2e-4)[smooth]
        assert slope.matrix[smooth] == pytest.approx(expected, rel=1e-3, abs=1e-4 * np.abs(expected).max())
        assert sides[0].tau is not None
        assert sides[1].tau is not None
        steepest = np.abs(sides[1].tau - sides[0].tau)[smooth] / 2e-4 / found.drawing.torque
        watched = found.drawing.task.geometry
        joints, apart = len(robot.joints), len(watched.pairs) + len(watched.grounded)
        torque = slope.left[smooth][:, -joints - apart : slope.left.shape[1] - apart]
        assert np.abs(torque) == pytest.approx(steepest, rel=1e-2, abs=1e-3 * steepest.max() + 1e-8)


def test_six_axes_get_a_better_motion_than_random_ones_within_every_limit():
    task, offer = offered(load_robot("tx40"), 6.0, 200)
    motion = reference_of_plan(offer.plan)
    assert not of_reference(task.robot, task.limits, task.geometry, motion)
    tau = followed(task.robot, motion.time, motion.q, motion.dq, motion.ddq).tau
    assert tau is not None
    assert (np.abs(tau) <= task.limits.torque).all()
    found = Setting(Drawing(task), motion.time, np.arange(len(task.robot.linear_parameters)))
    random = [found.samples(found.motion(x)).matrix for x in found.drawing.starts(6)]
    rank = np.linalg.matrix_rank(np.vstack(random).reshape(-1, random[0].shape[2]), rtol=1e-9)
    s = [np.linalg.svd(m.reshape(-1, m.shape[2]), compute_uv=False) for m in random]
    assert np.exp(-offer.best.score) < 0.2 * min(v[0] / v[rank - 1] for v in s)


def test_a_search_that_is_stopped_gives_its_best():
    names = list(limited().linear_parameters)
    found = setting(limited(), 3.0, [names.index("joint1.J_m"), names.index("joint1.viscous")])
    calls = []

    def stopping(share: float) -> None:
        calls.append(share)
        if len(calls) == 20:
            raise KeyboardInterrupt

    best = smallest_condition(found, found.drawing.starts(4), Budget(10_000, 1000), stopping)
    assert best.stopped
    score = -np.log(condition_number(found.samples(found.motion(best.x)).matrix))
    assert best.score == pytest.approx(score)


def test_the_command_s_criterion_is_kept_in_the_rehearsed_plan():
    planned = pi.excite(limited(), criterion="condition", duration=3.0, evaluations=200, floor=None)
    plain = pi.excite(limited(), duration=3.0, evaluations=30, floor=None)
    numbers = []
    for plan in (planned.plan, plain.plan):
        motion = reference_of_plan(plan)
        numbers.append(np.linalg.cond(np.hstack([motion.ddq, motion.dq, np.sign(motion.dq)])))
    assert numbers[0] < 0.9 * numbers[1]
