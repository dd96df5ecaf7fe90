"""What a residual depends on where no effect of the catalogue explains it.

On the equation with the largest excess, splines of every signal and waves of every frequency and order
compete; the best joins the base and the rest compete again. Replicas, analysed alike, show what the
method itself pretends of the splines; a peak counts against its own neighbours.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.diagnosis.base.projection import Base, extended, solve_base
from pyident.diagnosis.base.replicas import judged_replicas
from pyident.diagnosis.base.residual_over_floor import Examination, whitened
from pyident.diagnosis.base.setting import Setting, together
from pyident.diagnosis.unexplained.in_time import one_stretch
from pyident.diagnosis.unexplained.periodic import Spectrum
from pyident.diagnosis.unexplained.residual_terms import Dependence, RowSearch, excess, spline_gains
from pyident.diagnosis.unexplained.smooth import constant_columns, variables
from pyident.regression.spectrum import Floor, levels_of
from pyident.simulation.simulator import Simulator, Workers

_FIRST_SEED = 1_000_000


@dataclass(frozen=True)
class Unexplained:
    """sentences for `Diagnosis.depends_on`; dependences, spectra (of the first equation) for figures.

    rows   equations that were looked at
    """

    sentences: tuple[str, ...]
    dependences: tuple[Dependence, ...]
    spectra: tuple[Spectrum, ...]
    rows: tuple[int, ...]


def depends_on(
    examination: Examination, workers: Workers, base: Base | None = None, among: Container[int] | None = None
) -> Unexplained:
    """What the residual of an examination depends on.

    base      the examination's own, or with accepted candidates joined to it
    workers   processes that hold the fitted robot's FMU
    among     equations that are asked about; none: all
    """
    base, rules = base or examination.base, examination.setting.rules.unexplained
    replicas = examination.setting.rules.replicas.splines
    floor = examination.floor_energies
    total = max(float(excess(base, floor).sum()), 1e-300)
    found: list[Dependence] = []
    spectra: list[Spectrum] = []
    sentences: list[str] = []
    rows: list[int] = []
    while len(rows) < rules.equations:
        beyond = excess(base, floor)
        beyond[[i for i in range(len(beyond)) if i in rows or not (among is None or i in among)]] = 0.0
        row = int(np.argmax(beyond))
        if beyond[row] <= rules.equation * total:
            break
        rows.append(row)
        sentences += _happened(examination, base, row)
        pretended = _pretended_by_replicas(examination, workers, row, replicas)
        search = RowSearch(examination, base, row, total, pretended)
        own = search.run(floor)
        base = search.base
        found += own
        spectra = spectra or search.spectra
        sentences.append(_sentence(examination.setting.robot, row, own))
    return Unexplained(tuple(sentences), tuple(found), tuple(spectra), tuple(rows))


def _happened(examination: Examination, base: Base, row: int) -> list[str]:
    """Where nearly all that is left of an equation lies in one stretch of time: a sentence."""
    left, setting = [r[row] for r in base.residual], examination.setting
    floor = float(examination.floor_energies[row])
    found = one_stretch(examination.logs, left, floor, setting.rules.unexplained)
    if found is None:
        return []
    where = f"{found.start:.3g} and {found.end:.3g} s after the start of {setting.logs[found.log].source}"
    side, percent = side_of(setting.robot, row), 100 * found.share
    return [f"{side}: {percent:.0f} % of what is left lies between {where}; did something touch it there?"]


def _pretended_by_replicas(examination: Examination, workers: Workers, row: int, count: int) -> np.ndarray:
    """(count, variables) energies that the splines explain of replicas, 0 where a signal stands still."""
    asked = [(v.name, v.form) for v in variables(examination.setting.robot, examination.logs, row)]
    arguments = examination.setting, examination.floors, row, asked
    seeds = range(_FIRST_SEED, _FIRST_SEED + count)
    jobs = [workers.submit(_pretended, *arguments, group) for group in together(seeds)]
    return np.array([gains for job in jobs for gains in job.result()])


def _pretended(
    fmu: Simulator,
    setting: Setting,
    floors: Sequence[Floor],
    row: int,
    asked: Sequence[tuple[str, str]],
    seeds: Sequence[int],
) -> list[np.ndarray]:
    """The energies of each replica, of signals by name and form."""
    found = []
    for made in judged_replicas(fmu, setting, seeds):
        data = whitened(setting.robot, made, floors)
        listed = variables(setting.robot, data, row)
        levels = levels_of(floors, data)
        base = extended(solve_base(data), constant_columns(data, levels, row))
        explained = spline_gains(base, listed, data, levels, row).tolist()
        gains = dict(zip(((v.name, v.form) for v in listed), explained, strict=True))
        found.append(np.array([gains.get(variable, 0.0) for variable in asked]))
    return found


def _sentence(robot: Robot, row: int, found: Sequence[Dependence]) -> str:
    if not found:
        return f"{side_of(robot, row)}: the residual depends on no single signal and has no period"
    said = ", then on ".join(clause(d, first=d is found[0]) for d in found)
    return f"{side_of(robot, row)}: depends on {said}"


def side_of(robot: Robot, row: int) -> str:
    """An equation in words."""
    coordinate = robot.q[row]
    side = "transmission" if coordinate.side == "transmission" else f"{coordinate.side} side"
    return f"{side} of joint {coordinate.joint}"


def clause(d: Dependence, first: bool) -> str:
    """In words; first: of its equation's. A rival that is the same signal has the other form."""
    unit = "rad" if d.form == "misread" else "N m"
    size = "" if d.amplitude is None else f", {d.amplitude:.3g} {unit}"
    pairs = zip(d.rivals, d.rival_signals, strict=True)
    others = [words for words, signal in pairs if signal != d.on][:2]
    as_well = f", as well as {' or '.join(others)}" if others else ""
    forms = ["as friction"] if d.form == "friction" else []
    if d.on in d.rival_signals:
        forms = ["as friction or as a force of either sign"]
    what = ", ".join([d.words, *forms])
    share = "all" if d.share_percent >= 99.5 else f"{d.share_percent:.0f} %"  # of what stands over a floor
    return f"{what} ({'explains ' if first else ''}{share} of the excess{size}{as_well})"
