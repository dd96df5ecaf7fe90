"""Robots with logs of known truth, or published values: what every estimator is held against."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.logs.datasets import fetch
from pyident.logs.foreign import import_log
from pyident.logs.log import Log
from pyident.logs.mapping import read_mapping
from pyident.simulation.fmu_runs import runs_in_threads

from ..coverage.study import noisy
from ..rigid_arm.arm import COULOMB, ROTOR, VISCOUS, arm, moved, recorded, torque_noise
from ..tx40.study import published_friction

LEVELS = (5e-7, 2e-6, 1e-5)  # rad, of the motors' encoders; those behind the gears have half of it
SECONDS = 20.0  # of the rigid arm's motion
STRETCHES = 2  # of the TX40's nine seconds


@dataclass(frozen=True)
class Case:
    """A robot whose parameters are `true`, name -> value, and its log by seed.

    logs   how many there are, where somebody measured them;  None: as many as are asked for
    """

    name: str
    robot: Robot
    true: dict[str, float]
    log: Callable[[int], Log]
    logs: int | None = None


def cases() -> list[Case]:
    """four_link at three levels of noise, and a rigid six-axis arm that Pinocchio moves, its loop unknown."""
    robot = load_robot("four_link")

    def logged(level: float) -> Callable[[int], Log]:
        def log(seed: int) -> Log:
            with runs_in_threads(robot) as simulate:
                return noisy(robot, simulate, level, seed)

        return log

    flexible = [
        Case(f"four_link, {level:g} rad", robot, robot.linear_parameters, logged(level)) for level in LEVELS
    ]
    return [*flexible, _rigid()]


def _rigid() -> Case:
    robot = arm()
    true = dict(robot.linear_parameters)
    for k in range(6):
        true |= {f"joint{k + 1}.{n}": 0.0 for n in ("offset",)}
        for name, values in (("J_m", ROTOR), ("coulomb", COULOMB), ("viscous", VISCOUS)):
            true[f"joint{k + 1}.{name}"] = float(values[k])

    def log(seed: int) -> Log:
        rng = np.random.default_rng(seed)
        motion = moved(robot, rng, SECONDS)
        tau = motion.load + ROTOR * motion.a + COULOMB * np.sign(motion.v) + VISCOUS * motion.v
        return recorded(motion, tau, torque_noise(tau), rng, f"log {seed}")

    return Case("rigid six-axis arm", robot, true, log)


def measured() -> Case:
    """The TX40's log in stretches, against friction that its authors published. Raises LogError."""
    robot = load_robot("tx40")
    whole = import_log(fetch("tx40", download=False), read_mapping("tx40"), robot)
    length = len(whole.frame) // STRETCHES

    def log(number: int) -> Log:
        frame = whole.frame.iloc[number * length : (number + 1) * length]
        return Log(frame.reset_index(drop=True), f"stretch {number + 1}")

    return Case("TX40 (measured)", robot, published_friction(), log, STRETCHES)
