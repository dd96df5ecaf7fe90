"""Motions from point to point: rest to rest, within the range, at the pace."""

from dataclasses import replace

import numpy as np
import pytest
from studies.hidden_effect.generator.cases import redrawn
from studies.hidden_effect.generator.logs_and_key import cases_of
from studies.hidden_effect.generator.run import inputs, points, standard
from studies.point_to_point import study

from flexmodels.files.robot_file import load_robot

PERIOD, PACE = 0.004, 0.9
TIME = np.arange(5000) * PERIOD


def plan():
    return replace(standard(load_robot("four_link")), pace=PACE)


def test_a_motion_rests_between_points_and_keeps_its_pace():
    reference = points(plan(), TIME, np.random.default_rng(3))
    speed = np.gradient(reference, PERIOD, axis=0)
    at_rest = np.all(np.abs(speed) < 1e-9, axis=1)
    starts = np.flatnonzero(np.diff(at_rest.astype(int)) == -1)
    assert at_rest[0]
    assert len(starts) >= 5
    assert 0.1 < at_rest.mean() < 0.5
    assert np.abs(speed).max() == pytest.approx(PACE, rel=0.05)
    assert np.all(np.abs(reference) <= np.abs(plan().swing) / 2)


def test_no_torque_is_fed_forward():
    reference, torque = inputs(load_robot("four_link"), plan(), TIME, np.random.default_rng(3))
    assert reference.shape == torque.shape == (len(TIME), 4)
    assert not torque.any()


def test_every_log_of_a_case_has_a_pace_and_a_redrawn_one_keeps_it():
    (drawn,) = cases_of(["stribeck"], 5)
    case = study.working(drawn)
    paces = [p.pace for p in case.plans]
    assert all(study.PACES[0] <= p <= study.PACES[1] for p in paces)
    assert len(set(paces)) == 3
    again = redrawn(case)
    assert again.id == case.id
    assert [p.pace for p in again.plans] == paces
    assert not any(p.pace for p in redrawn(drawn).plans)


@pytest.mark.slow
def test_a_robot_at_work_with_nothing_hidden_is_no_alarm(tmp_path):
    result = study.run(tmp_path, lambda _: None, cases=1)
    value = {r["what"]: r["value"] for r in result.rows}
    assert value["false alarm with nothing hidden"].startswith("0 % (0 of 1")
