"""The arm of a page: its keyframes are the motion, and no name leaves its quotes."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from pyident.kinematics.skeleton import skeleton
from pyident.report.moving_arm import FRAMES, element, moving, still


@pytest.fixture
def frame(four_link):
    time = np.arange(0, 5, 0.005)
    signals = {"time": time}
    for i, name in enumerate(four_link.coordinates):
        size = 0.8 if name.endswith(".e") else 1e-3
        signals[name] = size * np.sin((1 + i) * time)
    return pd.DataFrame(signals)


def test_the_ghost_is_log_less_what_was_missed(four_link, frame):
    missed = {"joint2.e": 0.01 * np.cos(frame["time"].to_numpy())}
    arm = moving(four_link, "log", frame, frame["time"].to_numpy(), missed, {2: 4.0})
    simulated = frame.assign(**{"joint2.e": frame["joint2.e"] - missed["joint2.e"]})
    at = np.searchsorted(frame["time"], arm.time)
    assert len(arm.time) == FRAMES
    assert arm.simulated is not None
    np.testing.assert_allclose(arm.simulated, skeleton(four_link, simulated.iloc[at]), atol=1e-12)
    np.testing.assert_allclose(arm.measured, skeleton(four_link, frame.iloc[at]), atol=1e-12)


def test_what_the_browser_gets_adds_up_to_the_motion(four_link, frame):
    """Rigid pose plus deltas: the poses to a micrometre, at 500 times the deformation to 0.01 mm."""
    arm = moving(four_link, "log", frame, frame["time"].to_numpy(), {}, {})
    content = arm.content()
    rigid, measured = np.array(content["rigid"]), np.array(content["measured"])
    np.testing.assert_allclose(measured, arm.measured - arm.rigid, atol=1e-8)
    np.testing.assert_allclose(rigid, arm.rigid, atol=1e-5)
    no_deformation = frame[[c for c in frame if ".eps" not in c]]
    at = np.searchsorted(frame["time"], arm.time)
    np.testing.assert_allclose(arm.rigid, skeleton(four_link, no_deformation.iloc[at]), atol=1e-12)
    assert len(json.dumps(content)) < 200_000


def test_joints_are_coloured_by_their_ratio(four_link, frame):
    ratios = {1: 1.0, 2: 3.0, 3: 10.0, 4: 300.0}
    arm = moving(four_link, "log", frame, frame["time"].to_numpy(), {}, ratios)
    colours = arm.content()["colours"]
    assert colours[0] == "#fffaf0"
    assert colours[2] == colours[3] == "#521d02"
    dark = [sum(int(c[i : i + 2], 16) for i in (1, 3, 5)) for c in colours[:4]]
    assert dark == sorted(dark, reverse=True)


def test_no_name_ends_the_script(four_link, frame):
    arm = moving(four_link, "</script><b>.csv", frame, frame["time"].to_numpy(), {}, {})
    html = element(arm, "arm")
    assert html.count("</script>") == 1
    content = re.search(r'getElementById\("arm"\), (.*)\)</script>', html)
    assert content
    assert json.loads(content[1])["log"] == "</script><b>.csv"


def test_a_standing_arm_has_one_frame(four_link):
    content = still(four_link).content()
    assert len(content["time"]) == 1
    assert content["simulated"] == []
