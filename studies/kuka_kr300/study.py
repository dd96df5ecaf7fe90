"""KUKA KR300: drive stiffness from motor and link encoders, whose samples are some milliseconds apart."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.coordinate import deformation_of, of_joint
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.checks.encoder_delay import Skew, encoder_skews, without_skew
from pyident.conditioning.filters import thin
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.logs.datasets import fetch
from pyident.logs.foreign import import_log
from pyident.logs.log import Log, LogError
from pyident.logs.mapping import read_mapping
from pyident.regression.equations import Problem
from pyident.regression.regressor import regressor
from pyident.report.page import Section, write_page
from pyident.rules.confidence import CONFIDENCE
from pyident.sweep.studies import StudyResult, row

from .instrumental import STRONG, two_stage

AUTHORS = (4.58e6, 7.52e6, 4.10e6)  # [N m/rad], axes 1 to 3
_LAGS = 25  # of 20 ms: half a second of correlated residuals


@dataclass(frozen=True)
class Balance:
    """Stiffness k [N m/rad] and its 95 % interval, viscous friction [N m s/rad], torque errors [%].

    plain   what least squares makes of k: too small, as twists are noisy
    F       strength of the instruments
    """

    k: float
    lower: float
    upper: float
    plain: float
    F: float
    viscous: float
    error: float
    other: float

    @property
    def told(self) -> bool:
        return self.F > STRONG and self.lower > 0


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Find and correct the skew, then the stiffness. Without the data the table says so."""
    robot = load_robot("kuka_kr300")
    try:
        files = fetch("kuka_kr300", download=False)
    except LogError as error:
        return StudyResult([], notes=[f"skipped: {error}"])
    raw = [import_log([file], read_mapping("kuka_kr300"), robot) for file in files]
    skews = [encoder_skews(robot, log) for log in raw]
    progress(0.5)
    delays = [_common(found) for found in skews]
    mended = [
        without_skew(log, _everywhere(found, d))[0] for log, found, d in zip(raw, skews, delays, strict=True)
    ]
    right = [_balance(robot, mended[0], mended[1], k) for k in (1, 2, 3)]
    again = [_balance(robot, mended[1], mended[0], k) for k in (1, 2, 3)]
    ignored = [_balance(robot, raw[0], raw[1], k) for k in (1, 2, 3)]
    together = [_of_all_equations(robot, log) for log in (mended[0], raw[0])]
    progress(1.0)
    table = pd.DataFrame(
        {
            "k, MN m/rad": [b.k / 1e6 for b in right],
            "from": [b.lower / 1e6 for b in right],
            "to": [b.upper / 1e6 for b in right],
            "least squares": [b.plain / 1e6 for b in right],
            "F of the instruments": [b.F for b in right],
            "k of run B": [b.k / 1e6 for b in again],
            "authors": [k / 1e6 for k in AUTHORS],
            "viscous, N m s/rad": [b.viscous for b in right],
            "k with the delay ignored": [b.k / 1e6 for b in ignored],
            "k of all equations": [k / 1e6 for k in together[0]],
            "k of all equations, delay ignored": [k / 1e6 for k in together[1]],
            "viscous with the delay ignored": [b.viscous for b in ignored],
            "error on A, %": [b.error for b in right],
            "error on B, %": [b.other for b in right],
        },
        index=[f"axis {k}" for k in (1, 2, 3)],
    )
    summary = (
        "Drive stiffness of a KUKA KR300 from motor and link encoders; run A identifies, run B validates."
    )
    page = write_page(
        folder / "index.html", "KUKA KR300", summary, [Section("Stiffness", table=_shown(table))]
    )
    return StudyResult([*_skew_rows(delays), *_rows(right, again, ignored, together)], [page])


def _shown(table: pd.DataFrame) -> pd.DataFrame:
    """A row per quantity, to four digits."""
    text = table.map(lambda value: f"{value:.4g}").T
    return text.rename_axis("quantity").reset_index()


def _common(skews: list[Skew]) -> Skew:
    """The delay of a run: the mean of its axes by their precision; it is one clock's."""
    weights = np.array([1 / s.std**2 for s in skews])
    mean = float(weights @ [s.delay for s in skews] / weights.sum())
    return Skew(0, mean, float(weights.sum() ** -0.5))


def _everywhere(skews: list[Skew], common: Skew) -> list[Skew]:
    return [Skew(s.joint, common.delay, common.std) for s in skews]


@dataclass(frozen=True)
class _Equations:
    """Of a moving motor: -eps (N,), the other columns (N, 4), instruments (N, Z), torque (N,)."""

    twist: np.ndarray
    exact: np.ndarray
    instruments: np.ndarray
    torque: np.ndarray

    @property
    def columns(self) -> np.ndarray:
        return np.column_stack([self.twist, self.exact])


def _equations(robot: Robot, log: Log, k: int) -> _Equations:
    part = condition(log, robot)
    Phi = regressor(robot, part.motion)
    names = ("J_m", "coulomb", "viscous", "offset")
    exact = Phi.matrix[:, k - 1, [Phi.columns.index(of_joint(k, name)) for name in names]]
    links = [i for i, name in enumerate(Phi.columns) if name.startswith("link")]
    of_links = Phi.matrix[:, k - 1, links]
    moving = part.use[:: part.thinning, k - 1] > 0

    def thinned(columns: np.ndarray) -> np.ndarray:
        return thin(columns, part.thinning)[moving]

    return _Equations(
        -thinned(part.motion.q[:, robot.coordinates.index(deformation_of(k))]),
        thinned(exact),
        thinned(of_links[:, of_links.any(axis=0)]),
        thinned(part.target[:, k - 1]),
    )


def _balance(robot: Robot, log: Log, other: Log, k: int) -> Balance:
    own, unseen = _equations(robot, log, k), _equations(robot, other, k)
    found = two_stage(own.twist, own.exact, own.instruments, own.torque, _LAGS)
    left = unseen.torque - unseen.columns @ found.p
    return Balance(
        k=float(found.p[0]),
        lower=float(found.p[0] - CONFIDENCE * found.std[0]),
        upper=float(found.p[0] + CONFIDENCE * found.std[0]),
        plain=float(np.linalg.lstsq(own.columns, own.torque, rcond=None)[0][0]),
        F=found.F,
        viscous=float(found.p[3]),
        error=float(100 * np.linalg.norm(found.residual) / np.linalg.norm(own.torque)),
        other=float(100 * np.linalg.norm(left) / np.linalg.norm(unseen.torque)),
    )


def _of_all_equations(robot: Robot, log: Log) -> list[float]:
    """Stiffness of axes 1 to 3 that the regression of motors and links together finds."""
    found = weighted(Problem(robot, (condition(log, robot),)))
    return [float(found.solution.p[found.reduced.columns.index(of_joint(k, "k[1]"))]) for k in (1, 2, 3)]


def _skew_rows(delays: list[Skew]) -> list[dict[str, str]]:
    return [
        row(
            f"link encoders of run {name} are late by",
            f"{1e3 * d.delay:.2f} ± {1e3 * d.std:.2f} ms",
            "about 3 ms",
            abs(1e3 * d.delay - 3) < 0.5,
        )
        for name, d in zip("AB", delays, strict=True)
    ]


def _rows(
    right: list[Balance], again: list[Balance], ignored: list[Balance], together: list[list[float]]
) -> list[dict[str, str]]:
    rows = []
    for k, (b, on_b, wrong, theirs) in enumerate(zip(right, again, ignored, AUTHORS, strict=True), start=1):
        text = f"{_interval(b)}; {_interval(on_b)} from run B; authors {theirs / 1e6:.2f}"
        rows.append(
            row(f"axis {k}: stiffness, MN m/rad", text if b.told else "not identifiable from this run")
        )
        rows.append(row(f"axis {k}: torque error on A, on B", f"{b.error:.1f} %, {b.other:.1f} %"))
        text = f"{wrong.viscous:.0f} N m s/rad (with it: {b.viscous:.0f})"
        rows.append(row(f"axis {k}: viscous friction with the delay ignored", text))
        if b.told:
            motor = f"{wrong.k / 1e6:.2f} (with it: {b.k / 1e6:.2f})"
            both = f"{together[1][k - 1] / 1e6:.2f} (with it: {together[0][k - 1] / 1e6:.2f})"
            rows.append(row(f"axis {k}: stiffness with the delay ignored", f"{motor}; all equations {both}"))
    return rows


def _interval(b: Balance) -> str:
    return f"{b.k / 1e6:.2f} ({b.lower / 1e6:.2f} to {b.upper / 1e6:.2f})"
