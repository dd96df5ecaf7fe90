"""A robot of one rigid joint whose simulation takes milliseconds."""

from flexmodels.experiment import Experiment, identification
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller
from flexmodels.settings.motions import Identification, Multisine
from flexmodels.settings.settings import Settings

PERIOD = 0.004


def one_joint() -> Robot:
    """An arm of 2 kg about an upright axis, with viscous and Coulomb friction."""
    laws = {"motor_inertia": {"J_m": 0.5}, "coulomb": {"coulomb": 1.0}, "viscous": {"viscous": 2.0}}
    joint = Joint("revolute", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), False, laws)
    link = Link(2.0, (1.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.6, 0.0, 0.6))
    return Robot(
        "one_joint",
        (joint,),
        (link,),
        tip=(1.0, 0.0, 0.0),
        controller=Controller(1 / PERIOD, (400.0,), (20.0,), (800.0,)),
        settings=Settings(identification=Identification((1.0,), 0.4, 0.4, Multisine((1.0,), 5, 1.0, 10.0))),
    )


def swing(duration: float = 0.4) -> Experiment:
    return identification(one_joint(), duration=duration)
