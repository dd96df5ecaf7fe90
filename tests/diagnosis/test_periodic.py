"""Waves in a residual: the order, frequency and amplitude that were put in, and none where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import INERTIA, analytic_log, free_joint

from flexmodels.effects import CATALOGUE
from flexmodels.files.robot_file import load_robot
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.nonlinear_values import of_whole_periods
from pyident.diagnosis.base.order_peaks import order_peaks, orders_told
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.unexplained import residual_terms
from pyident.diagnosis.unexplained.periodic import Over, highest, misread_columns, spectrum
from pyident.logs.log import Log
from pyident.regression.spectrum import equations
from pyident.rules.rules import RULES

SIGMA = 0.05  # N m of white noise: the floor


def _residual(disturbance):
    """Whitened equations of the joint under noise and a torque, f(log's frame) [N m]."""
    robot = free_joint()
    log = analytic_log(seconds=24.0, torque_noise=SIGMA)
    frame = log.frame.copy()
    frame["joint1.tau"] += disturbance(frame)
    return _whitened(robot, replace(log, frame=frame))


def _whitened(robot, log: Log):
    parts = equations(robot, [condition(log, robot)], [log.period])
    levels = [np.full_like(e.y, SIGMA) for e in parts]
    return robot, parts, levels, solve_base([e.over(level) for e, level in zip(parts, levels, strict=True)])


def _highest(base, parts, levels, over: Over):
    data = base, parts, levels
    return highest(*data, spectrum(*data, over, RULES.periodic), RULES.periodic)


def test_the_order_of_an_angle():
    _, parts, levels, base = _residual(lambda f: 0.3 * np.cos(7 * f["joint1.e"] + 0.4))
    peak = _highest(base, parts, levels, Over("order", 0))
    assert peak is not None
    assert peak.at == pytest.approx(7, abs=0.05)
    assert peak.amplitude == pytest.approx(0.3, rel=0.1)
    assert peak.p_value < 1e-6


def test_a_frequency():
    _, parts, levels, base = _residual(lambda f: 0.2 * np.sin(2 * np.pi * 6.3 * f["time"]))
    peak = _highest(base, parts, levels, Over("frequency", 0))
    assert peak is not None
    assert peak.at == pytest.approx(6.3, abs=0.02)
    assert peak.amplitude == pytest.approx(0.2, rel=0.1)
    assert peak.p_value < 1e-6


def test_noise_has_no_wave():
    _, parts, levels, base = _residual(lambda f: 0.0)
    for kind in ("order", "frequency"):
        peak = _highest(base, parts, levels, Over(kind, 0))
        assert peak is None or peak.p_value > 0.01, kind


def test_a_misread_angle_shows_in_the_torque_as_its_second_derivative():
    """One rigid joint: to first order an angle read as q + s sin 5q lacks J s (sin 5q)''."""
    robot, parts, levels, _ = _residual(lambda f: 0.0)
    motion = parts[0].part.motion
    q, v, a = motion.q[:, 0], motion.dq[:, 0], motion.ddq[:, 0]
    p = np.array(list(robot.linear_parameters.values()))
    (columns,) = misread_columns(robot, p, parts, levels, 0, 5.0)
    second = 5 * np.cos(5 * q) * a - 25 * np.sin(5 * q) * v**2
    first = 5 * np.cos(5 * q) * v
    expected = parts[0].band.transform((INERTIA * second + 2.0 * first) * parts[0].part.use[:, 0]) / SIGMA
    assert columns[0][:, 1] == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


def _peaks(torque, seconds: float = 24.0):
    robot = free_joint()
    log = analytic_log(seconds=seconds, torque_noise=SIGMA)
    frame = log.frame.copy()
    frame["joint1.tau"] += torque(frame["joint1.e"], np.sign(np.gradient(frame["joint1.e"])))
    parts = equations(robot, [condition(replace(log, frame=frame), robot)], [log.period])
    return order_peaks(robot, parts, np.array(list(robot.linear_parameters.values())), RULES.periodic, [1])[1]


def test_the_orders_of_gears_stand_out_the_strongest_first():
    found = _peaks(lambda q, _: 0.4 * np.cos(37 * q + 0.3) + 0.2 * np.sin(91 * q))
    assert found.steady[:2] == pytest.approx([37.0, 91.0], abs=0.3)


def test_the_orders_of_friction_stand_out_where_it_is_turned_as_the_motion_is():
    found = _peaks(lambda q, way: 0.4 * way * np.cos(53 * q + 0.3))
    assert found.friction[0] == pytest.approx(53.0, abs=0.3)
    assert found.steady == []


def test_noise_has_no_order():
    found = _peaks(lambda q, _: 0 * q)
    assert found.steady == found.friction == []


def test_a_torque_is_a_ripple_where_the_joint_passes_three_periods_of_it():
    found = _peaks(lambda q, _: 0 * q)
    turns = replace(found, least=7.3)
    ripple, friction = CATALOGUE["torque_ripple"], CATALOGUE["position_dependent_friction"]
    tried = {law.name: [v["order"] for v in turns.beside(_grid(law), law)] for law in (ripple, friction)}
    assert min(tried["torque_ripple"]) == 7.3
    assert max(tried["torque_ripple"]) == 30
    assert min(tried["position_dependent_friction"]) == 1
    span = np.ptp(analytic_log(seconds=24.0).frame["joint1.e"])
    assert found.least == pytest.approx(3 * 2 * np.pi / span, rel=0.02)
    assert replace(found, least=np.inf).beside(_grid(ripple), ripple) == []


def test_of_a_transmission_s_error_the_joint_passes_one():
    turns = replace(_peaks(lambda q, _: 0 * q), least=12.0)
    law = CATALOGUE["kinematic_error"]
    assert min(v["order"] for v in turns.beside(_grid(law), law)) == 4


def test_what_answers_the_speed_is_asked_as_a_ripple_and_as_friction_too():
    found = replace(_peaks(lambda q, _: 0 * q), least=7.3, answered=[314.0])
    for law in (CATALOGUE["torque_ripple"], CATALOGUE["position_dependent_friction"]):
        assert found.beside(_grid(law), law)[-1]["order"] == 314.0


def _grid(law) -> list[dict[str, float]]:
    return [{"order": order} for order in law.order.grid]


def test_a_slow_torque_hides_no_ripple():
    """Of these orders 2, 4 and 6 follow a slow torque, and 12 a ripple."""
    ripples = [Candidate("torque_ripple", 1, (("order", order),)) for order in (6.0, 4.0, 2.0, 12.0, 14.0)]
    kept = of_whole_periods(free_joint(), ripples, [20.0, 80.0, 90.0, 40.0, 5.0])
    assert [(c.values[0][1], i) for c, i in kept] == [(12.0, 3), (14.0, 4)]
    assert of_whole_periods(free_joint(), ripples[:3], [20.0, 80.0, 90.0]) == []
    friction = [Candidate("position_dependent_friction", 1, c.values) for c in ripples[:3]]
    assert [i for _, i in of_whole_periods(free_joint(), friction, [20.0, 80.0, 90.0])] == [2, 1, 0]


@pytest.mark.parametrize(
    ("model", "said"), [("four_link", "12, 24 per turn"), ("emps", "1.91, 3.82 per metre")]
)
def test_orders_of_a_slider_are_told_per_metre(model, said):
    assert orders_told(load_robot(model), 1, [12.0, 24.0]) == said


def test_what_a_residual_may_be_periodic_in():
    """Of a slider's place as of an angle, as the pitch of a linear motor; no encoder of it turns."""
    assert residual_terms._overs(load_robot("emps"), 0) == [Over("frequency", 0), Over("order", 0, 0)]
    turning = residual_terms._overs(load_robot("tx40"), 1)
    assert turning == [Over("frequency", 1), *(Over("order", 1, k) for k in range(6)), Over("misread", 1, 1)]
