"""What the data could have shown: every effect's smallest detectable amplitude; and where they stand out."""

from collections.abc import Iterator

import numpy as np

from pyident.candidates import law_of
from pyident.diagnosis import Limit, Row
from pyident.examination import EDGES, Examination
from pyident.law_columns import coverage, effect_columns
from pyident.search import Search

_IMITATED = 0.01  # share of a column that the base must leave, else it is not seen
_WHOLE = 100.0  # % of a row's own rms: no effect is larger
BALANCES = {"e": "motor", "eps[1]": "transmission", "eps[2]": "link", "eps[3]": "link"}


def limits(search: Search, material: float) -> Iterator[Limit]:
    """One per effect and joint of the search; material: least gain that is named, over the floor's energy."""
    ex, robot = search.examination, search.robot
    motion = ex.logs[0].part.motion
    for number, at in enumerate(search.families.values()):
        gains = [ex.gains[i] for i in at]
        best = min(range(len(at)), key=lambda j: float(gains[j].std[0]))
        c = ex.candidates[at[best]]
        if c.log not in (None, 0):
            continue
        law = law_of(robot, c)
        needed = np.sqrt(search.needed(number, material))
        smallest = {p.name: float(needed * s) for p, s in zip(law.linear, gains[best].std, strict=True)}
        share = _share(search, at[best], smallest[law.linear[0].name])
        seen = coverage(robot, c.joint, c.effect, motion, dict(c.values))
        reason = ""
        if gains[best].left < _IMITATED:
            reason = "the model's own parameters imitate it in these logs"
        elif seen is not None and seen < 1:
            reason = f"the logs do not cover what it needs: {law.needs}"
        elif share > _WHOLE:
            reason = "it would have to be larger than all else on its equation to be seen"
        units = robot.with_effect(c.joint, c.effect).units
        names = {p.name: units[f"joint{c.joint}.{c.effect}.{p.name}"] for p in law.linear}
        yield Limit(
            c.effect, f"joint{c.joint}", smallest, names, share, reason, law.experiment if reason else ""
        )


def rows_over_floor(ex: Examination) -> list[Row]:
    """Every equation's residual, per band of frequency, and over the replicas'."""
    robot, out = ex.setting.robot, []
    bands = tuple(zip(EDGES, (*EDGES[1:], ex.floor.frequencies[-1]), strict=True))
    mean = ex.replica_energy.mean(axis=0)
    for c, coordinate in enumerate(robot.coordinates):
        joint, name = coordinate.split(".", 1)
        at = np.digitize(ex.floor.frequencies, EDGES) - 1
        level = [
            float(np.sqrt(np.mean(ex.floor.rms[c][at == b] ** 2))) if (at == b).any() else 0.0
            for b in range(len(EDGES))
        ]
        ratio = np.sqrt(ex.energy[c] / np.maximum(mean[c], 1e-12))
        rms = np.sqrt(ex.energy[c]) * level
        out.append(Row(coordinate, joint, BALANCES[name], bands, tuple(rms.tolist()), tuple(ratio.tolist())))  # pyright: ignore
    return out


def _share(search: Search, candidate: int, amplitude: float) -> float:
    """rms of the first column at this amplitude, of the rms of its row's own torque [%]."""
    ex, robot = search.examination, search.robot
    c = ex.candidates[candidate]
    log = ex.logs[c.log or 0]
    slopes = effect_columns(robot, c.joint, c.effect, log.part.motion, dict(c.values))
    row, column = next(iter(next(iter(slopes.values())).items()))
    if row < len(robot.joints):
        own = log.part.target[:, row]
    else:
        coordinate = robot.coordinates[row]
        own = robot.parameters[coordinate.replace("eps", "k")] * log.part.motion.q[:, row]
    return float(100 * amplitude * np.sqrt(np.mean(column**2) / np.mean(own**2)))
