"""Logs of drives that bend: a link let go on its spring follows the plan that its motor was reckoned from."""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from studies.bending_drives import study
from studies.bending_drives.logs import DRIVE, KINDS, at_motors, case_list, made
from studies.foreign_logs.machines import drawn_machine
from studies.foreign_logs.methods import Answer
from studies.foreign_logs.motions import drawn_plan
from studies.foreign_logs.oracle import Oracle

pin = pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")


def test_links_on_their_springs_follow_the_plan():
    """Two hinges, integrated by DOP853 under the motors' motion: c M(q) q̈ = motor - q - c h(q, q̇)."""
    rng = np.random.default_rng(3)
    machine = next(m for m in iter(lambda: drawn_machine(rng, 2), None) if list(m.sliders) == [False, False])
    oracle, plan = Oracle(machine), drawn_plan(rng, machine.sliders, 3.0, False, False)
    compliance = np.array([2e-5, 1e-4])
    state, _ = at_motors(oracle, plan, compliance, 1000.0, 3.0)
    motor, data = CubicSpline(state.time, state.q), oracle.model.createData()

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        torque = (motor(t) - y[:2]) / compliance
        return np.concatenate([y[2:], pin.aba(oracle.model, data, y[:2], y[2:], torque)])

    q, v, _ = (x[0] for x in plan.at(np.zeros(1)))
    until = state.time[state.time < 0.5]
    found = solve_ivp(slope, (0, until[-1]), [*q, *v], "DOP853", until, rtol=1e-10, atol=1e-12).y[:2].T
    planned = plan.at(until)[0]
    assert np.abs(state.q[: len(until)] - planned).max() > 1e-4
    assert found == pytest.approx(planned, abs=1e-7)


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_what_is_hidden_is_what_the_kind_says(number):
    case = case_list(4, len(KINDS))[number]
    found = made(case)
    drives = [t for t in found.truth if t.law == DRIVE]
    expected = {"null": (0, 0), "strong": (1, 1), "medium": (1, 1), "pair": (2, 2), "law": (1, 2)}
    if case.kind in expected:
        assert (len(drives), len(found.truth)) == expected[case.kind]
    else:
        assert len(drives) == len(found.truth) >= 2
    assert all(t.amount is not None and t.amount > 0 for t in drives)
    assert len({t.names[0][1] for t in found.truth}) == len(found.truth)  # each at a joint of its own
    assert list(found.fit["time"][:2]) == [0.0, pytest.approx(1 / case.rate)]


def test_answers_are_counted(tmp_path, monkeypatch):
    """Of answers that are made up: the first drive 10 % too soft, and nothing else."""

    def solve(_, case, folder):
        truth = [{"law": DRIVE, "names": [[DRIVE, k]], "size": 8.0, "amount": 1e-4} for k in (1, 2)][
            : {"null": 0, "strong": 1, "medium": 1}.get(case.kind, 2)
        ]
        said = Answer("missing_effect", [[(DRIVE, 1)]]) if truth else Answer("nothing_detectable", [])
        folder.mkdir(parents=True, exist_ok=True)
        content = {"said": said.__dict__, "told": [[1, 1.1e-4]] if truth else [], "failure": ""}
        (folder / f"{case.id}.json").write_text(json.dumps(content | {"truth": truth, "besides": []}))

    for case in case_list(0, 6):
        solve(None, case, tmp_path / "seed_0")
    monkeypatch.setattr(study, "_solve", None)  # everything is there
    rows = {r["what"]: r["value"] for r in study.run(tmp_path, lambda _: None, 0, 6).rows}
    assert rows["rigid drives: false alarm"].startswith("0 of 1")
    assert rows["one drive, strong: named"].startswith("1 of 1")
    assert rows["two drives: both"].startswith("0 of 1")
    assert rows["every drive of a machine: of all these"].startswith("1 of 2")
    assert rows["of the compliances told: within 20 %"].startswith("5 of 5")
