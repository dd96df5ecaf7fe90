"""Periodic torques of a joint in closed form: of several orders, or with an amplitude that grows."""

import numpy as np
import pytest
from analytic_joint import INERTIA, free_joint, logs_with

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.searched import searched
from pyident.simulation.fmu_runs import runs_here

FALLS = 0.1  # s2/rad2: a third less at the rms speed
RESOLVED = 2.3  # orders per turn: two that lie as far apart differ by a period along this motion


def diagnosed(torque) -> Diagnosis:
    """Of two logs and a held-out one with a further torque f(q, v, load) [N m]; load: what moves the link."""
    logs = logs_with(torque)
    return concluded(searched(free_joint(), logs[:2], runs_here), runs_here, logs[2:])


def ripples(found: Diagnosis) -> list[float]:
    """Orders of the ripples that are named."""
    return [n.values["order"] for f in found.findings for n in f.tie if n.effect == "torque_ripple"]


@pytest.mark.parametrize(
    "torque",
    [
        lambda q, v, load: 0.3 * np.sin(9 * q) * v**2,
        lambda q, v, load: 0.4 * np.sin(13 * q + 0.4) * np.abs(v),
        lambda q, v, load: 0.2 * np.cos(11 * q) * np.abs(load) / INERTIA,
    ],
    ids=["square of the speed", "speed", "load"],
)
def test_a_periodic_torque_that_grows_with_a_signal_is_no_ripple(torque):
    found = diagnosed(torque)
    assert found.verdict == "unexplained"
    assert not ripples(found)


def test_a_hose_that_bends_is_a_spring_and_no_ripple():
    """Beside a straight line it makes a wave or two."""
    found = diagnosed(lambda q, v, load: 2.0 * np.tanh(1.5 * (q - 0.2)))
    assert {n.effect for f in found.findings for n in f.tie} & {"joint_spring", "gravity_spring"}
    assert not ripples(found)
    (limit,) = (x for x in found.limits if x.effect == "torque_ripple")
    assert limit.at.keys() == {"order"}  # for which it holds
    assert limit.units["order"] == "1"


@pytest.mark.parametrize("orders", [(9.0,), (9.0, 12.5), (16.0, 20.0)])
def test_a_ripple_has_the_orders_that_were_put_in(orders):
    amplitudes = (0.5, 0.35)[: len(orders)]
    found = diagnosed(
        lambda q, v, load: sum(a * np.sin(n * q + n) for a, n in zip(amplitudes, orders, strict=True))
    )
    (main,) = ripples(found)
    assert main == pytest.approx(orders[0], abs=0.05)
    assert found.findings[0].share_percent > 90
    further = [note for note in found.notes if "further orders" in note]
    listed = [float(n) for note in further for n in note.split(": ")[1].split(" per")[0].split(", ")]
    assert listed == pytest.approx(orders[1:], abs=RESOLVED / 10)


def test_a_ripple_that_falls_with_the_speed_keeps_its_name():
    """As one does that is faster than its sampling follows."""
    found = diagnosed(lambda q, v, load: 0.4 * np.sin(13 * q + 0.4) / (1 + FALLS * v**2))
    (main,) = ripples(found)
    assert main == pytest.approx(13.0, abs=0.1)
