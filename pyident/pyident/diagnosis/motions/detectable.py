"""What the data could have shown: every effect's smallest detectable amplitude; and where they stand out."""

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.stats import norm

from flexmodels.coordinate import joint_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of, slopes, units_of
from pyident.diagnosis.base.projection import Gain
from pyident.diagnosis.base.residual_over_floor import EDGES, Examination
from pyident.diagnosis.result import Limit, Row
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.regression.candidate_columns import coverage
from pyident.regression.spectrum import Equations
from pyident.rules.search import SearchRules

_POWER = float(norm.ppf(0.8))  # standard deviations, so that 80 % are found
_ALL_BUT = 0.99  # a law that must take all has no limit, but an infinite one
# A law stands in the log from which its floor is measured, and raises it. With 1.0 in its place 25 of 38 laws
# were named at their limit, with 1.15 32 of 44, with 1.3 36 of 38 (foreign_logs, seeds 2101, 2113, 2101).
_RAISES = 1.25
_WHOLE = 100.0  # % of a row's own rms: no effect is larger


def limits(search: Search, beside: Search | None = None, held: HeldOut | None = None) -> Iterator[Limit]:
    """One per effect and joint of the search.

    beside   the search that rests on what was named;  held: held-out logs on which a name must hold
    """
    ex, beside, held = search.examination, beside or search, held or HeldOut(())
    unseen = sum(e.y.shape[1] for e in held.equations)
    ratio = sum(e.y.shape[1] for e in ex.logs) / unseen if unseen else 0.0
    left: dict[tuple[int, ...], tuple[float, float]] = {}
    for number, at in enumerate(search.families.members.values()):
        best = min(at, key=lambda i: float(ex.gains[i].alone.min()))
        c = ex.candidates[best]
        if c.log in (None, 0) and not c.speeds:
            rows = tuple(search.rows(c))
            if rows not in left:
                left[rows] = beside.remaining_on(rows), held.left(beside, rows)
            least = max(search.needed(number), search.rules.material * search.floor_energy_on(rows))
            needed = needed_gain(search.rules, least, *left[rows], ratio)
            yield limit_of(search.robot, ex.logs[0], c, ex.gains[best], needed, search.rules)


def needed_gain(rules: SearchRules, least: float, left: float, unseen: float, ratio: float) -> float:
    """Gain of a law, in units of the floor, with which the gate lets four of five pass.

    least    that it must have to be no chance, and to matter
    left     energy beyond the floor on its equations, of which it must take a share;  unseen: the same of
             held-out logs
    ratio    number of fitted over that of held-out equations; 0: there are none
    A gain of G has a standard deviation of 2 √G, and its root one of 1.
    """
    share, again = (min(asked, _ALL_BUT) for asked in (rules.explained[0], rules.unseen))
    beyond = (unseen * ratio * again - left) / (1 - again)
    root = np.sqrt(max(least, left * share / (1 - share), beyond)) + _POWER
    return float(max(root, 2 * (rules.chance + _POWER) * np.sqrt(ratio)) ** 2)


def limit_of(
    robot: Robot, log: Equations, c: Candidate, explained: Gain, needed: float, rules: SearchRules
) -> Limit:
    """A candidate's limit along a log's motion. needed: gain that it would be named for."""
    law = law_of(robot, c)
    amplitudes = zip(law.linear, _RAISES * np.sqrt(needed) * explained.alone, strict=True)
    smallest = {p.name: float(size) for p, size in amplitudes if np.isfinite(size)}
    share = _share(robot, log, c, smallest)
    seen = coverage(robot, c.joint, c.effect, log.part.motion, dict(c.values))
    reason = ""
    if explained.left < rules.imitated:
        reason = "the model's own parameters imitate it in these logs"
    elif seen is not None and seen < 1:
        reason = f"the logs do not cover what it needs: {law.needs}"
    elif share > _WHOLE:
        reason = "it would have to be larger than all else on its equation to be seen"
    units = units_of(robot, c)
    names = {name: units[name] for name in (*smallest, *dict(c.values))}
    experiment = law.experiment if reason else ""
    return Limit(c.effect, joint_name(c.joint), smallest, names, share, reason, experiment, dict(c.values))


def rows_over_floor(ex: Examination) -> list[Row]:
    """Every equation's residual, rms in every band of frequency, and over the replicas'."""
    robot, out, top = ex.setting.robot, [], float(ex.floor.frequencies[-1])
    edges = [edge for edge in EDGES if edge < top]
    bands = tuple(zip(edges, (*edges[1:], top), strict=True))
    mean = ex.replica_energy.mean(axis=0)
    at = np.digitize(ex.floor.frequencies, edges) - 1
    part_of_all = np.sqrt(ex.count / sum(log.band.length for log in ex.logs))  # a band's rms per its level
    for c, coordinate in enumerate(robot.q):
        squares = np.square(ex.floor.rms[c])
        level = np.array(
            [np.sqrt(np.mean(squares[at == b])) if (at == b).any() else 0.0 for b in range(len(edges))]
        )
        found = np.sqrt(ex.energy[c, : len(edges)])
        ratio = found / np.sqrt(np.maximum(mean[c, : len(edges)], 1e-12))
        rms = found * level * part_of_all[: len(edges)]
        joint = joint_name(coordinate.joint)
        found_in = tuple(rms.tolist()), tuple(ratio.tolist())
        out.append(Row(coordinate.name, joint, coordinate.side, bands, *found_in))
    return out


def _share(robot: Robot, log: Equations, c: Candidate, smallest: Mapping[str, float]) -> float:
    """rms of the least of the parameters' forces, of the rms of its row's own torque [%]."""
    of = slopes(robot, c, log.part.motion)
    found = []
    for name, amplitude in smallest.items():
        row, column = next(iter(of[name].items()))
        stiffness = robot.q[row].stiffness
        if stiffness is None:
            own = log.part.target[:, row]
        else:
            own = robot.parameters[stiffness] * log.part.motion.q[:, row]
        found.append(100 * amplitude * float(np.sqrt(np.mean(column**2) / max(np.mean(own**2), 1e-300))))
    return min(found, default=float("inf"))
