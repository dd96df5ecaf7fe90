"""What the data could have shown: every effect's smallest detectable amplitude; and where they stand out."""

from collections.abc import Iterator, Mapping

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.base.projection import Gain
from pyident.diagnosis.base.residual_over_floor import EDGES, Examination
from pyident.diagnosis.result import Limit, Row
from pyident.diagnosis.search.search import Search
from pyident.regression.candidate_columns import coverage, effect_columns
from pyident.regression.spectrum import Equations

_IMITATED = 0.01  # share of a column that the base must leave, else it is not seen
_WHOLE = 100.0  # % of a row's own rms: no effect is larger


def limits(search: Search, material: float) -> Iterator[Limit]:
    """One per effect and joint of the search; material: least gain that is named, over the floor's energy."""
    ex = search.examination
    for number, at in enumerate(search.families.values()):
        best = min(at, key=lambda i: float(ex.gains[i].alone.min()))
        c = ex.candidates[best]
        if c.log in (None, 0):
            yield limit_of(search.robot, ex.logs[0], c, ex.gains[best], search.needed(number, material))


def limit_of(robot: Robot, log: Equations, c: Candidate, explained: Gain, needed: float) -> Limit:
    """A candidate's limit along a log's motion. needed: gain that it would be named for."""
    law = law_of(robot, c)
    amplitudes = zip(law.linear, np.sqrt(needed) * explained.alone, strict=True)
    smallest = {p.name: float(size) for p, size in amplitudes if np.isfinite(size)}
    share = _share(robot, log, c, smallest)
    seen = coverage(robot, c.joint, c.effect, log.part.motion, dict(c.values))
    reason = ""
    if explained.left < _IMITATED:
        reason = "the model's own parameters imitate it in these logs"
    elif seen is not None and seen < 1:
        reason = f"the logs do not cover what it needs: {law.needs}"
    elif share > _WHOLE:
        reason = "it would have to be larger than all else on its equation to be seen"
    units = robot.with_effect(c.joint, c.effect).units
    names = {name: units[parameter_name(c.joint, c.effect, name)] for name in smallest}
    return Limit(
        c.effect, joint_name(c.joint), smallest, names, share, reason, law.experiment if reason else ""
    )


def rows_over_floor(ex: Examination) -> list[Row]:
    """Every equation's residual, per band of frequency, and over the replicas'."""
    robot, out = ex.setting.robot, []
    bands = tuple(zip(EDGES, (*EDGES[1:], ex.floor.frequencies[-1]), strict=True))
    mean = ex.replica_energy.mean(axis=0)
    for c, coordinate in enumerate(robot.q):
        at = np.digitize(ex.floor.frequencies, EDGES) - 1
        level = [
            float(np.sqrt(np.mean(ex.floor.rms[c][at == b] ** 2))) if (at == b).any() else 0.0
            for b in range(len(EDGES))
        ]
        ratio = np.sqrt(ex.energy[c] / np.maximum(mean[c], 1e-12))
        rms = np.sqrt(ex.energy[c]) * level
        out.append(
            Row(
                coordinate.name,
                joint_name(coordinate.joint),
                coordinate.side,
                bands,
                tuple(rms.tolist()),
                tuple(ratio.tolist()),
            )
        )  # pyright: ignore
    return out


def _share(robot: Robot, log: Equations, c: Candidate, smallest: Mapping[str, float]) -> float:
    """rms of the least of the parameters' forces, of the rms of its row's own torque [%]."""
    slopes = effect_columns(robot, c.joint, c.effect, log.part.motion, dict(c.values))
    found = []
    for name, amplitude in smallest.items():
        row, column = next(iter(slopes[name].items()))
        stiffness = robot.q[row].stiffness
        if stiffness is None:
            own = log.part.target[:, row]
        else:
            own = robot.parameters[stiffness] * log.part.motion.q[:, row]
        found.append(100 * amplitude * float(np.sqrt(np.mean(column**2) / max(np.mean(own**2), 1e-300))))
    return min(found, default=float("inf"))
