"""Noisy logs of the two-joint robot, with or without a hidden law; simulations in this process."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.replica import Repeat

TWO_LINK = Path(__file__).parent / "robots" / "two_link.toml"
_PERIOD = 1 / 250


def two_link() -> Robot:
    return load_robot(TWO_LINK)


def hidden() -> Robot:
    """Joint 2 takes more torque in one direction than in the other."""
    values = {"joint2.asymmetric_coulomb.coulomb": 2.5, "joint2.asymmetric_coulomb.viscous": 4.0}
    return two_link().with_effect(2, "asymmetric_coulomb").with_parameters(values)


def made_log(fmu: LoadedFmu, robot: Robot, seed: int, seconds: float = 10.0, louder: float = 1.0) -> Log:
    """Swings under a multisine, 2 and 1 µrad of noise, or `louder` times that."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds / _PERIOD)) * _PERIOD
    swing = [1 - np.cos(2 * np.pi * time / (period + 0.3 * seed)) for period in (2.7, 3.4)]
    lines = np.linspace(0.5, 40, 60)
    waves = [
        np.cos(2 * np.pi * np.outer(time, lines) + rng.uniform(0, 2 * np.pi, 60)).sum(axis=1)
        for _ in range(2)
    ]
    plan = Experiment(time, 0.6 * np.column_stack(swing), np.column_stack(waves) * (4.0, 1.5))
    noise = {c: louder * (2e-6 if c.endswith(".e") else 1e-6) for c in robot.coordinates}
    log = Repeat(Log(fmu.simulate(plan), f"log {seed}"), plan).replica(
        fmu.simulate, robot.parameters, noise, seed
    )
    return Log(log.frame, f"log {seed}")


@contextmanager
def loaded(robot: Robot, folder: Path) -> Iterator[LoadedFmu]:
    path = folder / f"{robot.name}_{len(robot.parameters)}.fmu"
    with LoadedFmu(export_fmu(equations(robot), path, light=True)) as fmu:
        yield fmu


in_process = runs_here  # what opens a pool, without processes


_IDENTIFICATION = """
[identification]
swing = [1.2, 1.2]
period = 4.1
duration = 20.5
[identification.multisine]
rms = [20.0, 8.0]
lines = 204
lowest = 0.12
highest = 50.0
"""


def planned(folder: Path) -> str:
    """The file of the two-link robot with an experiment, so that cases can be drawn from it."""
    file = folder / "two_link.toml"
    controller, rest = TWO_LINK.read_text().split("[[joint]]", maxsplit=1)
    file.write_text(f"{controller}{_IDENTIFICATION}[[joint]]{rest}")
    return str(file)
