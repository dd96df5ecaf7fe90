"""Hidden friction at the motor hinge."""

import casadi as ca

from flexmodels.coordinate import motor_of, of_joint

from .law import dry, law


@law("stribeck", lambda d: {"excess": d.strong(0.8, 1.4, d.value("coulomb")), "speed": d.between(0.05, 0.2)})
def _stribeck(arm, k, c, _):
    v = arm.de(k)
    arm.resist(motor_of(k), c["excess"] / (1 + (v / c["speed"]) ** 2) * dry(v))


@law(
    "asymmetric_coulomb",
    lambda d: {
        "half": d.sign() * d.strong(0.4, 0.7, d.value("coulomb")),
        "slope": d.sign() * d.strong(0.1, 0.4, d.value("viscous")),
        "width": d.between(0.005, 0.03),
    },
)
def _asymmetric_coulomb(arm, k, c, _):
    v = arm.de(k)
    step = ca.tanh(v / c["width"])
    arm.resist(motor_of(k), (c["half"] * dry(v) + c["slope"] * v) * step)


@law(
    "load_dependent_friction",
    lambda d: {"share": d.strong(0.12, 0.25, 1), "smooth": d.load(0.02, 0.08)},
    joints=(1, 2, 3),
)
def _load_dependent_friction(arm, k, c, _):
    level = ca.sqrt(arm.load(k) ** 2 + c["smooth"] ** 2)
    arm.resist(motor_of(k), c["share"] * level * dry(arm.de(k)))


@law(
    "presliding",
    lambda d: {
        "bristle": d.strong(0.004, 0.012, 1),
        "sigma1": d.between(0.0, 0.02),
        "kind": float(d.rng.integers(2)),
    },
)
def _presliding(arm, k, c, numbers):
    """Dry friction builds up over a path: LuGre's bristle, or four Maxwell elements that slip in turn."""
    v, level = arm.de(k), arm.own[of_joint(k, "coulomb")]
    if numbers["kind"]:
        paths = [c["bristle"] * s for s in (0.3, 0.8, 1.8, 3.5)]
        z = [
            arm.state(of_joint(k, f"slip{i}"), lambda z, p=p: v / p - ca.fabs(v) / p * z * ca.fabs(z))
            for i, p in enumerate(paths)
        ]
        force = sum(z) / len(z)
    else:
        path = c["bristle"]
        z = arm.state(of_joint(k, "bristle"), lambda z: v / path - ca.fabs(v) / path * z)
        force = z + c["sigma1"] * (v - ca.fabs(v) * z)
    arm.resist(motor_of(k), level * (force - dry(v)))


@law(
    "nonlinear_viscous",
    lambda d: {
        "coefficient": d.sign() * d.strong(0.5, 0.8, d.value("viscous")),
        "cubic": float(d.rng.integers(2)),
    },
)
def _nonlinear_viscous(arm, k, c, numbers):
    v = arm.de(k)
    bent = v**3 - 0.3 * v if numbers["cubic"] else v * (v**2 + 1e-4) ** 0.35
    arm.resist(motor_of(k), c["coefficient"] * bent)


@law(
    "position_dependent_friction",
    lambda d: {
        "first": d.strong(0.6, 0.9, d.value("coulomb")),
        "second": d.strong(0.1, 0.25, d.value("coulomb")),
        "phase1": d.phase(),
        "phase2": d.phase(),
    },
)
def _position_dependent_friction(arm, k, c, _):
    e = arm.e(k)
    level = c["first"] * ca.cos(e - c["phase1"]) + c["second"] * ca.cos(2 * e - c["phase2"])
    arm.resist(motor_of(k), level * dry(arm.de(k)))


@law(
    "viscous_drift",
    lambda d: {"cold": d.strong(0.8, 1.4, d.value("viscous")), "warm_up": d.between(5, 12)},
)
def _viscous_drift(arm, k, c, _):
    arm.resist(motor_of(k), c["cold"] * ca.exp(-arm.t / c["warm_up"]) * arm.de(k))
