"""A folder with a robot of one joint and two noisy logs in which a law is hidden."""

from pathlib import Path

import numpy as np
from one_joint import one_joint
from two_link_logs import loaded

from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import save_robot
from flexmodels.robot import Robot
from pyident.logs.log import Log, write_log
from pyident.simulation.replica import Repeat


def hidden() -> Robot:
    """The one joint takes more torque in one direction than in the other."""
    values = {"joint1.asymmetric_coulomb.coulomb": 1.5, "joint1.asymmetric_coulomb.viscous": 2.0}
    return one_joint().with_effect(1, "asymmetric_coulomb").with_parameters(values)


def recorded(folder: Path) -> None:
    """A robot file and two logs of a robot with a hidden law."""
    save_robot(one_joint(), folder / "robot.toml")
    with loaded(hidden(), folder) as fmu:
        for seed, name in enumerate(("a", "b"), start=1):
            plan = motion(seed)
            clean = Repeat(Log(fmu.simulate(plan), name), plan)
            log = clean.replica(fmu.simulate, hidden().parameters, {"joint1.e": 2e-6}, seed)
            write_log(log, folder / f"{name}.parquet")
    for file in folder.glob("*.fmu"):
        file.unlink()


def motion(seed: int) -> Experiment:
    time = np.arange(1000) * 0.004
    angle = 0.8 * (1 - np.cos(2 * np.pi * time / (1.7 + 0.3 * seed)))
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, 30)
    waves = np.cos(2 * np.pi * np.outer(time, np.linspace(0.5, 30, 30)) + phases).sum(axis=1)
    return Experiment(time, angle[:, None], 3 * waves[:, None])
