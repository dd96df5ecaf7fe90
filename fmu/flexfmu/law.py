"""The law that a controller hands to a plant with drives: a torque, the time and motion at which it was
computed, and how it changes beside them.

A master that steps both side by side hands a torque on one communication step late. Held as a number it makes
a stiff loop unstable; as a law it answers to the motion at which it arrives. This is co-simulation with an
interface Jacobian (Sicklinger et al., Int. J. Numer. Meth. Engng 98, 2014), evaluated by the plant.
"""

from collections.abc import Iterator

from flexfmu.variable import Variable
from flexmodels.coordinate import of_joint, torque_of
from flexmodels.mechanics.plant import Equations


def law_names(joint: int) -> list[str]:
    """Its variables of a joint, in the order of runtime/loop/drive.h."""
    further = ("e_sampled", "de_sampled", "stiffness", "damping", "tau_rate")
    return [torque_of(joint), *(of_joint(joint, name) for name in further)]


SAMPLED = "controller.sampled"  # behind all of them


def law_inputs(eq: Equations) -> list[Variable]:
    """Of a plant with drives; while stiffness, damping and rate are 0 the torque alone counts."""
    texts = (
        "Torque of motor {k} at e_sampled and de_sampled, taken by the drive when it changes",
        "Position of motor hinge {k} at which the torque was computed",
        "Speed of motor hinge {k} at which the torque was computed",
        "How much the torque of motor {k} falls per position beyond e_sampled",
        "How much the torque of motor {k} falls per speed beyond de_sampled",
        "How fast the torque of motor {k} rises after the sample",
    )
    listed = [
        Variable(name, "input", "discrete", unit, text.format(k=k), 0.0)
        for text, row in zip(texts, _by_quantity(eq), strict=True)
        for k, (name, unit) in enumerate(row, start=1)
    ]
    return [*listed, Variable(SAMPLED, "input", "discrete", "s", "When the torques were computed", 0.0)]


def law_outputs(eq: Equations) -> list[Variable]:
    """Of a controller, beside its torques."""
    texts = (
        "Position of motor hinge {k} at the last sample",
        "Speed of motor hinge {k} at the last sample",
        "How much the torque of joint {k} falls per position beyond e_sampled; 0 while it is limited",
        "How much the torque of joint {k} falls per speed beyond de_sampled; 0 while it is limited",
        "How fast the torque of joint {k} rises if the reference goes on as before; 0 while it is limited",
    )
    listed = [
        Variable(name, "output", "discrete", unit, text.format(k=k))
        for text, row in zip(texts, _by_quantity(eq)[1:], strict=True)
        for k, (name, unit) in enumerate(row, start=1)
    ]
    return [*listed, Variable(SAMPLED, "output", "discrete", "s", "Time of the last sample, from the start")]


def _by_quantity(eq: Equations) -> list[list[tuple[str, str]]]:
    """Names and units."""
    return [list(row) for row in zip(*(_of_one(eq, k) for k in range(1, eq.joints + 1)), strict=True)]


def _of_one(eq: Equations, joint: int) -> Iterator[tuple[str, str]]:
    sliding = eq.prismatic[joint - 1]
    sliding_units = ("N", "m", "m/s", "N/m", "N.s/m", "N/s")
    turning_units = ("N.m", "rad", "rad/s", "N.m/rad", "N.m.s/rad", "N.m/s")
    yield from zip(law_names(joint), sliding_units if sliding else turning_units, strict=True)
