"""Hidden laws of the flexible hinge."""

import casadi as ca

from flexmodels.coordinate import deformation_of, of_joint

from .law import dead_zone, law


@law(
    "hardening_stiffness",
    lambda d: {
        "stiffer": d.strong(0.5, 0.9, d.value("k[1]")),
        "scale": float(d.levels.twist[d.k - 1]) * d.between(0.9, 1.3),
        "kind": float(d.rng.integers(2)),
    },
)
def _hardening_stiffness(arm, k, c, numbers):
    x, scale = arm.eps(k, 1), c["scale"]
    if numbers["kind"]:  # a second spring that comes to bear beyond a knee
        arm.resist(deformation_of(k), c["stiffer"] * dead_zone(x, scale, 0.15 * scale))
    else:
        arm.resist(deformation_of(k), c["stiffer"] * (1.2 * scale * ca.sinh(x / (1.2 * scale)) - x))


@law(
    "backlash",
    lambda d: {"half": d.strong(0.35, 0.6, float(d.levels.twist[d.k - 1])), "round": d.between(0.05, 0.2)},
)
def _backlash(arm, k, c, _):
    x = arm.eps(k, 1)
    gap = dead_zone(x, c["half"], c["round"] * c["half"]) - x
    arm.resist(deformation_of(k), arm.own[of_joint(k, "k[1]")] * gap)


@law(
    "transmission_hysteresis",
    lambda d: {
        "torque": d.load(0.2, 0.4),
        "path": float(d.levels.twist[d.k - 1]) * d.between(0.4, 0.8),
        "shape": d.between(0.5, 0.8),
    },
)
def _transmission_hysteresis(arm, k, c, _):
    """Bouc and Wen."""
    rate, shape = arm.deps(k, 1), c["shape"]

    def slip(z):
        return (rate - shape * ca.fabs(rate) * z * ca.fabs(z) - (1 - shape) * rate * z**2) / c["path"]

    arm.resist(deformation_of(k), c["torque"] * arm.state(of_joint(k, "bouc_wen"), slip))


@law(
    "stiffness_coupling",
    lambda d: {"turn2": d.sign() * d.strong(0.05, 0.12, 1), "turn3": d.sign() * d.strong(0.05, 0.12, 1)},
)
def _stiffness_coupling(arm, k, c, _):
    """The principal axes of the stiffness are turned."""
    s2, c2, s3, c3 = ca.sin(c["turn2"]), ca.cos(c["turn2"]), ca.sin(c["turn3"]), ca.cos(c["turn3"])
    Q = ca.blockcat([[c2, -s2, 0], [s2, c2, 0], [0, 0, 1]]) @ ca.blockcat(
        [[c3, 0, -s3], [0, 1, 0], [s3, 0, c3]]
    )
    K = ca.diag(ca.vertcat(*(arm.own[of_joint(k, f"k[{i}]")] for i in (1, 2, 3))))
    eps = ca.vertcat(*(arm.eps(k, i) for i in (1, 2, 3)))
    more = (Q @ K @ Q.T - K) @ eps
    for i in (1, 2, 3):
        arm.resist(deformation_of(k, i), more[i - 1])


@law(
    "kinematic_error",
    lambda d: {
        "first": d.strong(0.25, 0.45, float(d.levels.twist[d.k - 1])),
        "second": d.strong(0.05, 0.15, float(d.levels.twist[d.k - 1])),
        "teeth": float(d.rng.integers(6, 25)),
        "phase1": d.phase(),
        "phase2": d.phase(),
    },
)
def _kinematic_error(arm, k, c, _):
    """The gear's output is ahead by delta(e): the spring sees eps1 - delta, and turns the motor back."""
    N, e, x = c["teeth"], arm.e(k), arm.eps(k, 1)
    delta = c["first"] * ca.sin(N * e + c["phase1"]) + c["second"] * ca.sin(2 * N * e + c["phase2"])
    arm.potential(arm.own[of_joint(k, "k[1]")] * (delta**2 / 2 - x * delta))
