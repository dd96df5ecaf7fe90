"""A robot that is written is read as the same robot, whatever its values."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmodels.files.robot_file import load_robot, save_robot, shipped
from flexmodels.joint import Limits
from flexmodels.settings.controller import Controller
from flexmodels.settings.processing import Processing

FINITE = st.floats(-1e6, 1e6, allow_nan=False)
POSITIVE = st.floats(1e-6, 1e6)
TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=20)


def _again(robot, tmp_path_factory):
    file = tmp_path_factory.mktemp("robot") / "robot.toml"
    save_robot(robot, file)
    return load_robot(file)


@st.composite
def _values(draw, robot):
    """Values of the laws that their bounds allow, and bodies moved a little: real bodies stay real."""
    values = {}
    for name, old in robot.parameters.items():
        if name.startswith("link"):
            values[name] = old * (1 + draw(st.floats(-1e-4, 1e-4)))
        elif name.endswith(".offset"):
            values[name] = draw(FINITE)
        else:
            values[name] = draw(POSITIVE)
    return values


@settings(max_examples=20, deadline=None)
@given(st.data())
def test_values(tmp_path_factory, data):
    robot = load_robot("four_link")
    changed = robot.with_parameters(data.draw(_values(robot)))
    assert _again(changed, tmp_path_factory) == changed


@settings(max_examples=20, deadline=None)
@given(
    description=TEXTS,
    rate=st.floats(1.0, 1e5),
    gains=st.lists(FINITE, min_size=12, max_size=12),
    cutoff=st.none() | POSITIVE,
    decimate=st.integers(1, 100),
    dead_zone=st.floats(0, 10),
    limits=st.tuples(FINITE, FINITE).map(sorted),
    gravity=st.tuples(FINITE, FINITE, FINITE),
)
def test_settings(tmp_path_factory, description, rate, gains, cutoff, decimate, dead_zone, limits, gravity):
    robot = load_robot("four_link")
    Kp, Kd, Ki = (tuple(gains[i : i + 4]) for i in (0, 4, 8))
    first = replace(robot.joints[0], limits=Limits(position=tuple(limits), speed=1.0, effort=None))
    plan = Processing(cutoff=cutoff, decimate=decimate, dead_zone=dead_zone)
    changed = replace(
        robot,
        description=description,
        gravity=gravity,
        controller=Controller(rate, Kp, Kd, Ki),
        settings=replace(robot.settings, processing=plan),
        joints=(first, *robot.joints[1:]),
    )
    assert _again(changed, tmp_path_factory) == changed


@pytest.mark.parametrize("name", sorted(shipped()))
def test_twice_written_is_once_written(tmp_path, name):
    """To the byte: what a file says does not depend on how often it was saved."""
    save_robot(load_robot(name), tmp_path / f"{name}.toml")
    first = (tmp_path / f"{name}.toml").read_bytes()
    save_robot(load_robot(tmp_path / f"{name}.toml"), tmp_path / f"{name}.toml")
    assert (tmp_path / f"{name}.toml").read_bytes() == first


def test_a_body_by_its_centre_is_the_same_body(tmp_path):
    """Steiner: J about the joint = J_com + m (c·c 1 − c cᵀ)."""
    text = shipped()["parallelogram"].read_text()
    assert "J_com" in text or "ms" in text
    c, m, diagonal = np.array([0.1, -0.2, 0.3]), 4.0, np.array([0.5, 0.6, 0.7])
    file = tmp_path / "one.toml"
    file.write_text(
        f"[[joint]]\nx = [0, 0, 1]\ny = [0, 1, 0]\n[[link]]\nm = {m}\ncom = {c.tolist()}\n"
        f"J_com = {diagonal.tolist()}\n"
    )
    (link,) = load_robot(file).links
    J = np.diag(diagonal) + m * (c @ c * np.eye(3) - np.outer(c, c))
    assert link.ms == pytest.approx(m * c)
    assert pytest.approx(J[np.triu_indices(3)]) == link.J
