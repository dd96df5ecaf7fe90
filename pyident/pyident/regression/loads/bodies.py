"""What a robot's own links ask of its joints along a motion, and the laws that read it."""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import sympy

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect
from flexmodels.joint import Joint, parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.smooth_motion import without_noise
from pyident.regression.links import LinkColumns
from pyident.regression.recent import Recent

_BLOCK = 1000  # samples at a time
_loads: Recent[np.ndarray] = Recent(4)
_quiet: Recent[Motion] = Recent(8)


def link_torques(robot: Robot, motion: Motion) -> np.ndarray:
    """(N, joints) [N m, N]: M(q) q̈ + h(q, q̇) of the robot's own bodies at its motors, without their inertias.

    What laws add to the last body is of it. Raises ValueError as `regressor` does.
    """
    p, joints = bodies(robot).ravel(), len(robot.joints)
    torques = np.empty((len(motion.q), joints))
    for part, Phi in _blocks(robot, motion):
        torques[part] = Phi[:, :joints] @ p
    return torques


def carried_loads(robot: Robot, motion: Motion) -> np.ndarray:
    """(N, joints) [N m, N]: what a log's motion without its noise asks of the motors, as of `link_torques`.

    Friction turns the sign of a load: noise in it would not cancel, but be friction.
    """

    def carried() -> np.ndarray:
        return link_torques(robot, _quiet.of((motion,), lambda: without_noise(motion)))

    return _loads.of((robot, motion), carried)


def link_columns(robot: Robot, motion: Motion, joint: int) -> np.ndarray:
    """(N, 10 links): what one unit of each of the links' parameters asks of a joint, from 1, at its motor.

    In the order of `link_names`. Raises ValueError as `regressor` does.
    """
    return np.concatenate([Phi[:, joint - 1].copy() for _, Phi in _blocks(robot, motion)])


def _blocks(robot: Robot, motion: Motion) -> Iterator[tuple[slice, np.ndarray]]:
    """Samples, and (B, n, 10 links) the links' columns of Φ there, which the next block overwrites."""
    width = len(LINK_PARAMETERS)
    columns = LinkColumns(robot, [width * k for k in range(len(robot.links))])
    rates = [np.ascontiguousarray(rate, float) for rate in (motion.q, motion.dq, motion.ddq)]
    Phi = np.zeros((min(_BLOCK, len(motion.q)), len(robot.coordinates), width * len(robot.links)))
    for start in range(0, len(motion.q), _BLOCK):
        q, dq, ddq = (rate[start : start + _BLOCK] for rate in rates)
        columns.fill(Phi[: len(q)], (q, dq, ddq))
        yield slice(start, start + len(q)), Phi[: len(q)]


def body_columns(robot: Robot, effect: Effect) -> Mapping[str, np.ndarray]:
    """Parameter name -> (10,), its column as a sum of those of the last link's; not to be changed."""
    return _weights(effect, tuple(map(float, robot.tip)))


@lru_cache(maxsize=64)  # a search asks for every replica
def _weights(effect: Effect, tip: tuple[float, ...]) -> Mapping[str, np.ndarray]:
    at_tip: dict[Any, Any] = dict(zip(signals.tip, tip, strict=True))
    return {
        parameter: np.array([float(sympy.sympify(slopes.get(p, 0)).subs(at_tip)) for p in LINK_PARAMETERS])
        for parameter, slopes in effect.body_columns.items()
        if slopes
    }


def reads_load(robot: Robot) -> bool:
    """Whether a law of the robot depends on what a transmission carries, and so on the robot's own values."""
    return any(map(carries_friction, robot.joints))


def carries_friction(joint: Joint) -> bool:
    """Whether a law of the joint depends on what its transmission carries."""
    return any(signals.load in law.symbols for law in joint.effects)


def body_laws(robot: Robot) -> Iterator[tuple[str, np.ndarray]]:
    """Parameter of every law that adds to the last link, and its column (10,) in terms of that link's."""
    for k, joint in robot.numbered:
        for effect in joint.effects:
            for parameter, weights in body_columns(robot, effect).items():
                yield parameter_name(k, effect.name, parameter), weights


def bodies(robot: Robot) -> np.ndarray:
    """(links, 10) the links' parameters, with what laws add to the last one."""
    own = np.array([[link.values[name] for name in LINK_PARAMETERS] for link in robot.links], float)
    for name, weights in body_laws(robot):
        own[robot.last_link - 1] += robot.parameters[name] * weights
    return own


def per_load(friction: np.ndarray, load: np.ndarray) -> np.ndarray:
    """(N,) friction per unit of the load (N,) that makes it; 0 where nothing is carried."""
    return np.divide(friction, load, out=np.zeros_like(load), where=load != 0)


def link_names(robot: Robot) -> list[str]:
    """Of the links' parameters, in the order of the links and of `LINK_PARAMETERS`."""
    return [f"link{k + 1}.{name}" for k in range(len(robot.links)) for name in LINK_PARAMETERS]
