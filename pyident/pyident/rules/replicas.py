"""Thresholds of replicas: how many there are, and how the bias of a fit is taken away with them."""

from dataclasses import dataclass

from pyident.rules.rule import in_range, rule


@dataclass(frozen=True)
class ReplicaRules:
    """How the method's own trace is measured."""

    count: int = rule(
        20,
        "replicas of a diagnosis",
        "the least possible p-value is 1/(1 + count), below `search.level`",
        "level 5 %",
    )
    probes: int = rule(
        4,
        "replicas per round that show the bias of a fit",
        "their mean scatters half as much as one (of 2: 71 %, of 8: 35 %)",
        "law of large numbers",
    )
    rounds: int = rule(
        3,
        "times that the bias is taken away",
        "each costs the probes once more",
        "by hand; on two sound arms of studies/rigid_arm 1, 2 or 6 change friction by less than 0.05 %",
    )
    step: float = rule(
        1e-4,
        "solver step [s] for a fit that cannot be simulated",
        "small beside the periods of the hinges",
        "four_link on its line: half and twice change its angles by less than 1e-8 rad",
    )
    inexact: float = rule(
        1e-3,
        "share of a torque and a deformation, at every frequency, to which no model is exact",
        "correct simulators differ by 2e-5 to 1e-3 at a motor, by how they integrate and round friction",
        "arms of studies/hidden_effect without noise, friction rounded over 1 and 5 mrad/s",
    )
    splines: int = rule(
        3,
        "replicas that show what splines pretend of an unexplained residual",
        "their largest counts",
        "exchangeable: chance alone exceeds the largest of 3 in 1 of 4 (of 2: in 1 of 3, of 6: 1 of 7)",
    )
    revealing: int = rule(
        3,
        "replicas of every motion that may show a law",
        "only their floor is used",
        "chi-square law: the mean of a line's squares scatters by 58 % (of 2: 71, of 6: 41)",
    )
    trial: int = rule(
        4,
        "replicas by which `add` judges",
        "only their mean square is used",
        "law of large numbers: their mean scatters half as much as one (of 2: 71 %, of 8: 35 %)",
    )

    def __post_init__(self) -> None:
        in_range(self, "replicas", 2, 10_000, "count", "trial")
        in_range(self, "replicas", 1, 1000, "probes", "splines", "revealing")
        in_range(self, "replicas", 0, 100, "rounds")
        in_range(self, "replicas", 0, 1, "inexact")
