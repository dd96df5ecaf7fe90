"""The families of candidates (an effect at a joint) and what replicas pretend of each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pyident.diagnosis.base.candidates import Family, bounds
from pyident.diagnosis.base.projection import Columns
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.search.joint_fit import JointFit


@dataclass(frozen=True, eq=False)
class Families:
    """Of an examination with C candidates in F families and B replicas.

    members        family -> numbers of its candidates
    columns        (C) of every candidate;  bounds: on their coefficients
    mean, spread   (F,) of a family's best gain in replicas: what varies without cause
    peaks          (B,) largest score of each replica against the others
    joint          fits of several candidates together
    """

    members: Mapping[Family, list[int]]
    columns: Sequence[Columns]
    bounds: list[tuple[np.ndarray, np.ndarray]]
    mean: np.ndarray
    spread: np.ndarray
    peaks: np.ndarray
    joint: JointFit


def families_of(examination: Examination) -> Families:
    """Columns and replicas' gains, sorted by family."""
    robot, listed = examination.setting.robot, examination.candidates
    own_trace = examination.setting.rules.search.own_trace
    names = [c.family for c in listed]
    members = {f: [i for i, g in enumerate(names) if g == f] for f in dict.fromkeys(names)}
    best = np.array([examination.replica_gains[:, at].max(axis=1) for at in members.values()]).T
    return Families(
        members,
        examination.columns,
        [bounds(robot, c) for c in listed],
        best.mean(axis=0),
        _spread(best, own_trace),
        np.array([_peak(best, b, own_trace) for b in range(len(best))]),
        JointFit(examination.base),
    )


def _spread(best: np.ndarray, own_trace: float) -> np.ndarray:
    """(F,) how much a family's gain varies without cause: its noise, and how the method's trace varies."""
    return best.std(axis=0) + 1.0 + own_trace * best.mean(axis=0)


def _peak(best: np.ndarray, b: int, own_trace: float) -> float:
    """The largest score of one replica against the others."""
    rest = np.delete(best, b, axis=0)
    return float(((best[b] - rest.mean(axis=0)) / _spread(rest, own_trace)).max())
