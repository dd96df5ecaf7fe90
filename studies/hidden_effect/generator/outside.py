"""Hidden laws that stand in no catalogue."""

import casadi as ca
import numpy as np

from flexmodels.coordinate import motor_of, of_joint

from .law import dry, law


@law(
    "mains_hum",
    lambda d: {"size": d.torque(0.15, 0.3), "frequency": d.between(6.5, 7.5), "phase": 0.0},
    per_log={"phase": (0.0, 2 * np.pi)},
    catalogue=False,
)
def _mains_hum(arm, k, c, _):
    """A torque of its own frequency, tied to no position: rectified mains in the amplifier."""
    arm.resist(motor_of(k), c["size"] * ca.sin(2 * np.pi * c["frequency"] * arm.t + c["phase"]))


@law("torque_sag", lambda d: {"per_speed": d.strong(0.2, 0.35, 1)}, catalogue=False)
def _torque_sag(arm, k, c, _):
    """The torque constant falls with speed."""
    v = arm.de(k)
    share = 1 - 1 / (1 + c["per_speed"] * ca.sqrt(v**2 + 1e-4))
    arm.resist(motor_of(k), share * arm.u[k - 1])


@law("bending_friction", lambda d: {"share": d.strong(0.15, 0.35, 1)}, joints=(1, 2, 3), catalogue=False)
def _bending_friction(arm, k, c, _):
    """The bending moment in the next joint loads this joint's bearing."""
    moments = [arm.own[of_joint(k + 1, f"k[{i}]")] * arm.eps(k + 1, i) for i in (2, 3)]
    level = ca.sqrt(moments[0] ** 2 + moments[1] ** 2 + 1)
    arm.resist(motor_of(k), c["share"] * level * dry(arm.de(k)))


@law(
    "base_flexibility",
    lambda d: {"k1": d.between(0.8e6, 1.5e6) / d.amplitude, "k2": d.between(0.8e6, 1.5e6) / d.amplitude},
    joints=(1,),
    tilting=True,
    catalogue=False,
)
def _base_flexibility(arm, k, c, _):
    """The floor gives way: the base tilts about two axes, with 2 % damping."""
    for i in (1, 2):
        at, stiff = arm.at(f"base.tilt[{i}]"), c[f"k{i}"]
        damp = 0.04 * ca.sqrt(stiff * 80.0)
        arm.resist(f"base.tilt[{i}]", stiff * arm.q[at] + damp * arm.v[at])


@law(
    "encoder_eccentricity",
    lambda d: {"size": d.strong(0.0015, 0.003, 1), "teeth": float(d.rng.integers(8, 17)), "phase": d.phase()},
    catalogue=False,
)
def _encoder_eccentricity(arm, k, c, _):
    """The loop distorts the measured angle; nothing to add to the arm."""


@law(
    "offset_step",
    lambda d: {"size": d.sign() * d.torque(0.15, 0.3), "moment": 9.0, "width": d.between(0.1, 0.8)},
    per_log={"moment": (5.0, 15.0)},
    catalogue=False,
)
def _offset_step(arm, k, c, _):
    """The amplifier's offset drifts to another level in mid-log."""
    arm.resist(motor_of(k), c["size"] * (1 + ca.tanh((arm.t - c["moment"]) / c["width"])) / 2)
