"""Values of a law that its logs do not tell by themselves, though they tell the law."""

import numpy as np
import pytest
from six_axis_logs import arm, made, plain

from pyident.diagnosis.coefficients import loosely_told
from pyident.diagnosis.searched import searched


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


def told(effect: str, force) -> dict[str, bool]:
    """Which parameters of an effect at joint 3 logs tell in which it makes this torque of angle and speed."""

    def friction(q, v, load, time):
        out = plain(q, v, load, time)
        out[:, 2] += force(q[:, 2], v[:, 2])
        return out

    search = searched(arm(), [made(arm(), seed, friction, 20.0) for seed in range(2)], never)
    found = search.best(effect, 3)
    assert found is not None
    linear = [p.name for p in search.robot.catalogue[effect].linear]
    names = (*linear, *dict(found.candidate.values))
    return dict(zip(names, ~loosely_told(search, (), found.candidate), strict=True))


def stop(q, v):
    """A spring above three quarters of the joint's range, none below."""
    return 60.0 * np.maximum(q - np.quantile(q, 0.75), 0.0)


def stribeck(q, v):
    return 3.0 * np.sign(v) * np.exp(-np.abs(v) / 0.05)


def short_hose(q, v):
    """A sixth of a period of a wave: four numbers of a long one do as well."""
    return 8.0 * np.sin((q - np.median(q)) * (np.pi / 3) / np.ptp(q))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "force", "known"),
    [
        ("slack_spring", stop, {"stiffness_above", "start_above"}),
        ("stribeck", stribeck, {"level", "velocity"}),
        ("gravity_spring", short_hose, set()),
    ],
)
def test_what_hangs_on_what_the_logs_leave_open_is_not_told(effect, force, known):
    """Of a stop at one end nothing is told of a spring at the other."""
    assert {name for name, tells in told(effect, force).items() if tells} == known
