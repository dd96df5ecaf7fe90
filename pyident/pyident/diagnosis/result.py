"""The outcome of a diagnosis: plain data, for machines, pages and people."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite
from pathlib import Path
from typing import Any, Literal

from flexmodels.coordinate import joint_number
from pyident.regression.descriptions import describes

VerdictName = Literal["nothing_detectable", "missing_effect", "unexplained", "cannot_tell"]


@dataclass(frozen=True)
class Named:
    """An effect at a joint, or an error of the robot file, with the parameters that fit best.

    values, std    parameter -> value and standard deviation (inf: a nonlinear one, or not determined); of the
                   floor's noise alone, and so no interval
    nonlinear      those that the logs determine of parameters that enter the law nonlinearly, and the
                   correction of a robot file
    units          parameter -> unit
    gain_percent   share of the base model's residual energy over the floor that it takes away by itself
    log            the only log in which it acts, None: all
    beside_percent the same beside the findings: what it would still take away; None where it was not asked
    """

    effect: str
    joint: str
    values: Mapping[str, float]
    std: Mapping[str, float]
    units: Mapping[str, str]
    gain_percent: float
    log: str | None = None
    beside_percent: float | None = None
    nonlinear: tuple[str, ...] = ()

    @property
    def describes(self) -> bool:
        """Whether it is an error of the robot file, not a law."""
        return describes(self.effect)

    def determines(self, parameter: str) -> bool:
        """Whether the logs determine a parameter by itself."""
        return self.std[parameter] != inf or parameter in self.nonlinear

    @property
    def where(self) -> str:
        """The law at its joint, and in which log alone."""
        return f"{self.effect} at {self.joint}{f' in {Path(self.log).name} only' if self.log else ''}"

    @property
    def suspect(self) -> str:
        """The law with its values, as `excite` takes it."""
        values = ",".join(f"{name}={value:.4g}" for name, value in self.values.items())
        return f"{self.effect}@{joint_number(self.joint)}={values}"


@dataclass(frozen=True)
class Finding:
    """One accepted effect, or several that these data cannot tell apart, the best first.

    p_value               one and the replicas in which the search finds as much, over one and all of them: a
                          probability as far as the noise in them is the log's
    excess_gain_percent   of the residual's energy, beyond what replicas pretend
    share_percent         of what exceeds the floor where it acts, in rows and bands: 100 explains it all; 0
                          where hardly anything exceeds it
    heldout_gain_percent  share of what exceeds the floor on its equations, on logs that were not used; None:
                          there were none
    heldout_std_percent   its standard deviation
    experiment            the motion that would separate the tie, empty when there is nothing to separate
    alike                 whether the tie's names describe one robot, so that any of them may be corrected
    replicas              number of them
    """

    tie: tuple[Named, ...]
    p_value: float
    excess_gain_percent: float
    share_percent: float
    heldout_gain_percent: float | None
    experiment: str = ""
    heldout_std_percent: float | None = None
    alike: bool = False
    replicas: int = 0

    @property
    def replicas_alike(self) -> int:
        """Number of replicas in which the search finds as much."""
        return round(self.p_value * (1 + self.replicas)) - 1

    @property
    def settled(self) -> bool:
        """Whether nothing is left to be told apart."""
        return len(self.tie) == 1 or self.alike


@dataclass(frozen=True)
class Limit:
    """The smallest amplitude of an effect at a joint that these data would have shown.

    smallest         linear parameter -> amplitude, in the parameter's unit
    share_percent    rms of that force, of the rms torque or moment on its row
    reason           why it cannot be seen at all, empty when it can
    at               nonlinear parameters, such as an order, for which it holds: those that show best
    """

    effect: str
    joint: str
    smallest: Mapping[str, float]
    units: Mapping[str, str]
    share_percent: float
    reason: str = ""
    experiment: str = ""
    at: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Row:
    """Where it fails: one equation, rms of its residual [N m] per frequency band [Hz], and over the floor."""

    coordinate: str
    joint: str
    balance: Literal["motor", "transmission", "link"]
    bands: tuple[tuple[float, float], ...]
    rms: tuple[float, ...]
    over_floor: tuple[float, ...]


@dataclass(frozen=True)
class Place:
    """What is said of one side of a joint.

    state             unobserved: no sample of the logs that are fitted is of use there
    over_floor        rms of its residual over that of replicas, before and after the findings
    band              Hz from and to, and that ratio after the findings, of the band where it stands out most;
                      None: in no band more than in all together
    floor_percent     rms that replicas leave, of the torque or moment on the equation; NaN where that is none
    reason            why the best candidate of an unexplained place is not named; empty elsewhere
    """

    joint: str
    balance: Literal["motor", "transmission", "link"]
    state: Literal["in_order", "explained", "unexplained", "unobserved"]
    over_floor: tuple[float, float]
    floor_percent: float
    reason: str = ""
    band: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Stage:
    """The residual's energy over the floor's with the effects of this stage and all before.

    added   the finding (its best candidate), None: the model as it is
    """

    added: Named | None
    over_floor: float


@dataclass(frozen=True)
class Diagnosis:
    """What is missing in a model of these logs.

    excess       energy of the residual over that of replicas, 1: at the floor
    remaining    the same with the findings
    ranking      every effect with its gain by itself, best first
    depends_on   where the verdict is `unexplained`: sentences on what the residual depends on
    draft        text of an effect file for an unexplained residual, where one was asked for and found
    places       every side of every joint: in order, explained or not
    band         highest frequency that was looked at [Hz]
    put_in_time  whether positions and torques were moved against each other before all was judged
    stages       the residual from the model as it is to the model with all findings
    """

    robot: str
    logs: tuple[str, ...]
    heldout: tuple[str, ...]
    verdict: VerdictName
    sentence: str
    findings: tuple[Finding, ...]
    localised: tuple[str, str] | None
    limits: tuple[Limit, ...]
    rows: tuple[Row, ...]
    excess: float
    remaining: float
    ranking: tuple[Named, ...]
    notes: tuple[str, ...] = ()
    depends_on: tuple[str, ...] = ()
    noise: Mapping[str, float] = field(default_factory=dict)
    stages: tuple[Stage, ...] = ()
    draft: str = ""
    places: tuple[Place, ...] = ()
    band: float = float("nan")
    put_in_time: bool = False

    def json(self) -> dict[str, Any]:
        """The contract of `diagnose --json`."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "findings": [
                {
                    "tie": [
                        {"effect": n.effect, "joint": n.joint} | ({"log": n.log} if n.log else {})
                        for n in f.tie
                    ],
                    "p_value": f.p_value,
                    "excess_gain_percent": f.excess_gain_percent,
                    "share_percent": f.share_percent,
                    "heldout_gain_percent": f.heldout_gain_percent,
                    "heldout_std_percent": f.heldout_std_percent,
                    "parameters": {
                        name: {"value": value, "unit": f.tie[0].units[name]}
                        for name, value in f.tie[0].values.items()
                    },
                    "experiment": f.experiment,
                }
                for f in self.findings
            ],
            "localised": dict(zip(("joint", "balance"), self.localised, strict=True))
            if self.localised
            else None,
            "not_observable": [
                {"effect": x.effect, "joint": x.joint, "reason": x.reason, "experiment": x.experiment}
                for x in self.limits
                if x.reason
            ],
            "smallest_detectable": [
                {"effect": x.effect, "joint": x.joint, "amplitude": dict(x.smallest), "units": dict(x.units)}
                for x in self.limits
                if not x.reason
            ],
            "places": [
                {
                    "joint": p.joint,
                    "balance": p.balance,
                    "state": p.state,
                    "over_floor": {"before": p.over_floor[0], "after": p.over_floor[1]},
                    "band": None
                    if p.band is None
                    else dict(zip(("from_hz", "to_hz", "over_floor"), p.band, strict=True)),
                    "floor_percent": p.floor_percent if isfinite(p.floor_percent) else None,
                    "reason": p.reason,
                }
                for p in self.places
            ],
            "band_hz": self.band,
            "over_floor": {"before": self.excess, "after": self.remaining},
            "depends_on": list(self.depends_on),
            "notes": list(self.notes),
        }
