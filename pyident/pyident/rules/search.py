"""Thresholds of the search for a missing effect: what counts, what ties, what is named."""

from dataclasses import dataclass

from pyident.rules.confidence import LEVEL
from pyident.rules.rule import RulesError, in_range, rule

_TUNING = (
    "by hand, before studies/hidden_effect was scored; half or twice changes no score of studies/thresholds"
)


@dataclass(frozen=True)
class SearchRules:
    """What a candidate must show to be named."""

    level: float = rule(LEVEL, "chance of a name when nothing is missing", "the usual level", "convention")
    material: float = rule(
        0.02,
        "floor's energy that a gain reaches",
        "less is not worth a name: the error falls by less than a hundredth",
        "by reason, after torques logged 0.1 samples early were named as delays at single joints",
    )
    explained: tuple[float, ...] = rule(
        (0.4, 0.65, 0.8),
        "excess on its equations that a set of one, two, three or more effects takes away",
        "a true effect explains 80 to 140 %, a wrong neighbour 13 %; more effects must explain more",
        "as `material`, 0.4 by reason later; in studies/thresholds twice withholds a wrong name",
    )
    unseen: float = rule(
        0.5,
        "share of the fitted logs that a set must take on held-out ones",
        "what is learnt by heart takes next to nothing there; a true effect takes as much",
        "by reason, after a wrong name for a cable; in studies/thresholds twice loses three names",
    )
    unseen_excess: float = rule(
        0.2, "floor's energy: held-out logs that exceed it by less have nothing to explain", "noise", _TUNING
    )
    again: float = rule(
        3.0,
        "standard deviations of an error's value in held-out logs, where shares say nothing",
        "one test on logs that chose nothing: a chance of 0.1 %",
        "normal law",
    )
    part: float = rule(
        0.1, "excess that each effect of a set takes away", "remainders are shared by many", _TUNING
    )
    own: float = rule(
        0.7, "what still exceeds the floor on its equations that a further effect takes", "as above", _TUNING
    )
    whole: float = rule(
        0.95,
        "what still exceeds the floor that a further small effect takes",
        "it may be a remainder",
        _TUNING,
    )
    together: int = rule(
        5,
        "effects of one set: each must hold on held-out logs beside the others",
        "a joint that lacks four laws shows none of them alone; each costs a search",
        "by reason, after four at one joint; sets of up to five have no wrong name for what no law is",
    )
    most: int = rule(24, "effects at once", "only a stop: several at every joint of an arm", "by reason")
    orders: int = rule(2, "further orders of a periodic law", "each costs a search", _TUNING)
    order: float = rule(0.3, "what still exceeds the floor that a further order takes", "as `own`", _TUNING)
    refine: float = rule(
        0.3, "best gain from which on a candidate's nonlinear values are refined", "time only", _TUNING
    )
    tie: float = rule(
        0.9, "best gain: who explains as much cannot be told from it", "gains' own scatter", _TUNING
    )
    apart: float = rule(
        0.5, "its own gain beside the best: who keeps more is another effect", "none: by reason", _TUNING
    )
    parameter: float = rule(
        0.5, "what a law with fewer parameters leaves: a richer law leaves less", "parsimony", _TUNING
    )
    chance: float = rule(
        5.0, "standard deviations by which a gain differs by chance", "two sides of 1e-6", "normal law"
    )
    stands_out: float = rule(
        1.0,
        "floor's energy by which a residual exceeds it",
        "the noise itself is known that well only",
        _TUNING,
    )
    band_stands_out: float = rule(
        3.0,
        "floor's energy in one band by which a residual exceeds it there: twice its rms",
        "a noise's spectrum is known that well; where it was not measured, it may rise besides",
        "by reason, after friction of 31 floors below 1 Hz was diluted to 1.4 by 60 Hz of noise",
    )
    worthless: float = rule(
        0.2,
        "a joint's torque that the floor reaches: 'nothing' then says little",
        "in a floor that high little can stand out",
        "by reason",
    )
    below_floor: float = rule(
        0.7,
        "floor's rms: a residual below it shows that the replicas are too noisy, and no law",
        "their own scatter",
        _TUNING,
    )
    own_trace: float = rule(
        0.5,
        "a family's mean gain in replicas: how well the method's own trace is known",
        "false alarms",
        _TUNING,
    )
    changes: float = rule(
        0.1,
        "excess on a law's equations gained by coefficients of its halves",
        "imitators gain more",
        _TUNING,
    )
    block: float = rule(
        0.05,
        "a joint's samples, its slowest and its fastest, that a named law can do without",
        "near rest friction is nobody's law; more would take what true laws live on",
        "by reason, after a coupling that fitted rounded friction; twice withholds one more wrong name",
    )
    block_gain: float = rule(
        0.5, "gain that a law may lose with them", "most of it must rest on the others", "by reason"
    )
    block_force: float = rule(
        0.1,
        "energy of its own force that makes a law one that acts in them: it may lose all",
        "twice what a force of constant size has there",
        "by reason: a law of motion near rest has more",
    )
    foreign_left: float = rule(
        0.05, "excess on a law's equations: who leaves less is no imitator", "true laws leave less", _TUNING
    )
    foreign_signal: float = rule(
        0.5, "what a law leaves, by one signal it does not know", "imitators", _TUNING
    )
    foreign_richer: float = rule(
        0.5, "what a law leaves: a smooth function has more parameters and leaves less", "parsimony", _TUNING
    )
    foreign_kept: float = rule(
        0.5, "a law's gain that is left beside the foreign signal", "imitators", _TUNING
    )
    power: float = rule(
        0.1,
        "energy that a joint's friction takes: with a further law it may put in no more than that",
        "friction cannot drive; an inexact fit near rest may say so for a few samples",
        "by reason, after a difference of 83 N m between directions was named beside 15 N m of friction",
    )
    imitated: float = rule(
        0.01,
        "a column that the base leaves, else it is not seen",
        "its coefficient would have no digits",
        "by reason",
    )

    def needed(self, effects: int) -> float:
        """Share of an excess that so many effects must take for their names."""
        return self.explained[min(effects, len(self.explained)) - 1]

    def __post_init__(self) -> None:
        shares = ("level", "part", "own", "whole", "order", "tie", "apart", "changes", "imitated")
        in_range(self, "search", 0, 1, *shares, "block", "block_gain", "block_force", "power")
        in_range(self, "search", 1, 100, "most", "together")
        if list(self.explained) != sorted(self.explained) or not all(0 < x <= 1 for x in self.explained):
            raise RulesError("rules: search.explained must rise, with shares between 0 and 1")
        if self.part > self.explained[0]:
            raise RulesError(
                "rules: search.part is above search.explained[0]; no single effect could fail it"
            )
