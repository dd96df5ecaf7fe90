"""A rigid robot in Pinocchio: a chain of hinges and sliders, each with the body on it."""

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from flexmodels.link import Link
from flexmodels.robot import Robot


def pinocchio() -> Any:
    """The package `pin`, whose names no type checker knows."""
    return import_module("pinocchio")


def chain(robot: Robot, scales: Sequence[float] | np.ndarray | None = None) -> Any:
    """pin.Model of the driven joints, without the motors.

    scales   factor on mass and inertia of each link; 1 without them
    """
    pin = pinocchio()
    model, before, axes = pin.Model(), 0, np.eye(3)
    model.gravity.linear = np.array(robot.gravity)
    scales = np.ones(len(robot.links)) if scales is None else scales
    for (k, joint), link, scale in zip(robot.numbered, robot.links, scales, strict=True):
        kind = pin.JointModelRX() if joint.kind == "revolute" else pin.JointModelPX()
        place = pin.SE3(axes.T @ joint.triad, axes.T @ np.array(joint.origin))
        before, axes = model.addJoint(before, kind, place, f"joint{k}"), joint.triad
        model.appendBodyToJoint(before, body(link, axes, float(scale)), pin.SE3.Identity())
    return model


def body(link: Link, triad: np.ndarray, scale: float = 1.0) -> Any:
    """pin.Inertia of a link in the axes of its joint's `triad` (3, 3), mass and inertia times `scale`."""
    if link.m == 0:
        raise ValueError("Pinocchio keeps the centre of mass, so a body needs a mass; give it one")
    com, J_com = link.about_centre()
    return pinocchio().Inertia(scale * link.m, triad.T @ com, scale * (triad.T @ J_com @ triad))


def inverse_dynamics(model: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Forces of the links (N, n) [N m or N], from positions, speeds and accelerations (N, n)."""
    pin, data = pinocchio(), model.createData()
    return np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
