"""The compiled Φ^(l) and the NumPy path are the same numbers; without a compiler NumPy takes over."""

import hashlib
import subprocess

import numpy as np
import pytest
from pinocchio_model import mixed_robot, random_motion, tree_robot

from flexmodels.compiling.compiler import BuildError
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression import links as link_columns
from pyident.regression.links import LinkColumns
from pyident.regression.machine import compiled
from pyident.regression.regressor import regressor

ROBOTS = [
    *(load_robot(name) for name in ("four_link", "emps", "parallelogram")),
    *(mixed_robot(2), tree_robot(1)),
]
SOURCE = "double twice(double x) { return 2 * x; }"


def link_columns_of(robot: Robot) -> LinkColumns:
    names = list(robot.parameters)
    return LinkColumns(robot, [names.index(f"link{k}.m") for k in range(1, len(robot.links) + 1)])


def filled(links: LinkColumns, robot: Robot, motion, *, samples_last: bool = False) -> np.ndarray:
    shape = len(motion[0]), len(robot.coordinates), len(robot.parameters)
    Phi = np.zeros((*shape[1:], shape[0])).transpose(2, 0, 1) if samples_last else np.zeros(shape)
    links.fill(Phi, motion)
    return Phi


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
@pytest.mark.parametrize("samples", [1, 7, 16, 29])
def test_compiled_and_numpy_are_the_same(robot: Robot, samples: int):
    motion, links = random_motion(robot, samples), link_columns_of(robot)
    assert (links.compiled is None) == (not links.structure.is_chain)
    ours, transposed = (filled(links, robot, motion, samples_last=last) for last in (False, True))
    links.compiled = None
    want = filled(links, robot, motion)
    np.testing.assert_allclose(ours, want, rtol=0, atol=1e-12 * np.abs(want).max())
    np.testing.assert_array_equal(transposed, ours)


def test_without_a_compiler_numpy_takes_over(monkeypatch, tmp_path, caplog):
    robot = load_robot("four_link")
    motion = Motion(*random_motion(robot, 20))
    want = regressor(robot, motion).matrix
    monkeypatch.setattr(link_columns, "_known", {})
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(compiled, "compiler", _none)
    with caplog.at_level("INFO"):
        assert link_columns_of(robot).compiled is None
        found = regressor(robot, motion).matrix
    assert "NumPy does the same" in caplog.text
    np.testing.assert_allclose(found, want, rtol=0, atol=1e-12 * np.abs(want).max())


def test_a_source_is_compiled_once(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path / "cache")
    assert compiled.library(SOURCE) is not None
    assert len(list((tmp_path / "cache").iterdir())) == 1
    monkeypatch.setattr(subprocess, "run", _none)
    assert compiled.library(SOURCE) is not None
    assert compiled.library(SOURCE + "\n") is None


def test_a_truncated_library_is_made_anew(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path)
    assert compiled.library(SOURCE) is not None
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.unlink()  # the file that is loaded stays whole: the process would die at its end
    file.write_bytes(whole[: len(whole) // 2])  # loading it would kill the process
    assert compiled.library(SOURCE) is not None
    (again,) = tmp_path.iterdir()
    assert again.stem.endswith(hashlib.sha256(again.read_bytes()).hexdigest())


def test_a_source_with_errors_leaves_nothing_behind(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path)
    assert compiled.library("this is not C") is None
    assert list(tmp_path.iterdir()) == []


def test_a_hinge_bent_too_far_is_named_by_either_path():
    robot = load_robot("four_link")
    q, dq, ddq = random_motion(robot, 30)
    q[11, robot.coordinates.index("joint3.eps[2]")] = 1.2
    links = link_columns_of(robot)
    for _ in range(2):
        with pytest.raises(ValueError, match=r"bent by 1\.\d+, .* check that eps is in rad"):
            filled(links, robot, (q, dq, ddq))
        links.compiled = None


def _none(*_, **__):
    raise BuildError("there is no compiler here")
