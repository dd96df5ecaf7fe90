"""What the page draws: thinned traces keep their peaks, the skeleton stands where the joints are."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pyident.comparison.bins import Bin
from pyident.kinematics.skeleton import segments, skeleton
from pyident.workbench import figures
from pyident.workbench.thinned import thinned, thinned_band, window
from pyident.workbench.view import View, view_of

pytest.importorskip("tsdownsample", reason="the workbench's extra is not installed")


def test_thinning_keeps_a_single_peak():
    time = np.arange(200_000) * 1e-3
    values = np.sin(time)
    values[123_456] = 5.0
    t, v = thinned(time, values)
    assert len(v) <= 2_000
    assert v.max() == 5.0
    assert t[np.argmax(v)] == pytest.approx(123.456)


def test_a_thinned_ribbon_covers_the_whole_one():
    time = np.arange(50_000) * 1e-3
    high = np.abs(np.random.default_rng(0).standard_normal(50_000))
    t, low, top = thinned_band(time, -high, high, 500)
    assert len(t) == 500
    assert top.max() == high.max()
    assert low.min() == -high.max()


def test_a_window_holds_its_span():
    time = np.arange(100) * 0.1
    part = time[window(time, (2.0, 3.0))]
    assert part[0] <= 2.0
    assert part[-1] >= 3.0
    assert len(part) < 15


def test_a_view_survives_its_url():
    view = View("where", "a.parquet", "joint2.eps[1]", (1.5, 2.5))
    from urllib.parse import parse_qsl

    assert view_of(dict(parse_qsl(view.query))) == view
    banded = View("why", coordinate="joint1.e", band=(0.5, 12.0))
    assert view_of(dict(parse_qsl(banded.query))) == banded
    assert view_of({"place": "elsewhere", "from": "x", "low": "3", "high": "2"}) == View()


def test_a_cell_of_the_map_is_its_band():
    listed = [
        Bin(c, "motor", "frequency", "", low, high, "Hz", 2.0, 3.0, 0.1, 0.1)
        for c in ("joint1.e", "joint2.e")
        for low, high in ((0.0, 0.5), (0.5, 12.3456))
    ]
    label = figures.band_map(listed)["data"][0]["x"][1]
    assert figures.band_of(listed, "joint2.e", label) == (0.5, 12.3456)
    assert figures.band_of(listed, "joint3.e", label) is None


def test_the_skeleton_turns_about_the_first_axis(four_link):
    """A quarter turn of joint 1 turns everything behind it about its axis, whatever the rest does."""
    rest = skeleton(four_link)[0]
    turned = skeleton(four_link, pd.DataFrame({"joint1.e": [np.pi / 2]}))[0]
    axis = np.array(four_link.joints[0].x, dtype=float)
    arm, moved = rest[-1] - rest[0], turned[-1] - turned[0]
    along = axis @ arm
    expected = axis * along + np.cross(axis, arm)
    np.testing.assert_allclose(moved, expected, atol=1e-12)


def test_the_skeletons_tip_is_the_simulations(four_link, identification_log):
    """Against the FMU's own tip: another derivation, motors and deformations at work."""
    frame = identification_log.frame.iloc[::250].reset_index(drop=True)
    points = skeleton(four_link, frame)
    tip = frame[["tip.x", "tip.y", "tip.z"]].to_numpy()
    np.testing.assert_allclose(points[:, -1], tip, atol=1e-6)
    assert len(segments(four_link)) == points.shape[1]


def trace(deformation: bool) -> Any:
    """Of a joint that turns back and forth under a ripple of seven waves a turn."""
    time = np.arange(2000) * 0.01
    angle = 8 * np.sin(0.3 * time)
    ripple = 0.3 * np.cos(7 * angle)
    return SimpleNamespace(
        time=time,
        position=angle,
        speed=np.gradient(angle, time),
        deformation=0.01 * angle if deformation else None,
        measured=ripple if deformation else np.zeros(2000),
        modelled=0 * time,
        residual=ripple,
        low=-np.ones(2000),
        high=np.ones(2000),
        used=np.ones(2000, bool),
    )


def test_the_orders_of_a_ripple_stand_at_their_number_and_height():
    spectrum = figures.states(trace(True), None)["data"][-1]
    assert spectrum["name"] == "orders of the angle"
    top = int(np.argmax(spectrum["y"]))
    assert spectrum["x"][top] == pytest.approx(7.0)
    assert spectrum["y"][top] == pytest.approx(0.3, rel=0.05)
    unused = trace(True)
    unused.used[:] = False
    assert figures.states(unused, None)["data"][-1]["x"] == []


@pytest.mark.parametrize("deformation", [True, False])
def test_what_a_joint_does_not_have_has_no_panel(deformation):
    bump = SimpleNamespace(start=3.0, stop=5.0)
    shown = figures.equation(trace(deformation), (2.0, 6.0), [bump, SimpleNamespace(start=9.0, stop=10.0)])
    names = [curve["name"] for curve in shown["data"]]
    assert ("deformation" in names) == deformation
    assert [note["text"] for note in shown["layout"]["annotations"]] == ["1"]  # the other is not in sight
    states = [curve["name"] for curve in figures.states(trace(deformation), (2.0, 6.0))["data"]]
    assert ("deformation" in states) == ("motor torque" in states) == deformation
