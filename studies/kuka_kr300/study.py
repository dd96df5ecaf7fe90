"""KUKA KR300: drive stiffness from motor and link encoders, whose samples are some milliseconds apart."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from statsmodels.regression.linear_model import OLS

from flexmodels.robot import Robot
from flexmodels.robot_file import load_robot
from pyident.conditioning import condition, thin
from pyident.data import fetch, shipped_mapping
from pyident.log import Log, LogError
from pyident.log_import import import_log
from pyident.report.page import Section, write_page
from pyident.skew import Skew, encoder_skews, without_skew
from pyident.studies import StudyResult, row

AUTHORS = (4.58e6, 7.52e6, 4.10e6)  # [N m/rad], axes 1 to 3
_LAGS = 25  # of 20 ms: half a second of correlated residuals


@dataclass(frozen=True)
class Balance:
    """Stiffness k between `lower` and `upper` [N m/rad], viscous friction [N m s/rad], errors [%].

    Neither torque nor twist is free of error, so the truth lies between the regression of the torque and
    that of the twist (Frisch 1934); the ends are theirs, widened by 1.96 standard deviations.
    """

    k: float
    lower: float
    upper: float
    viscous: float
    error: float
    other: float

    @property
    def told(self) -> bool:
        return 0 < self.lower < self.upper


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Find and correct the skew, then the stiffness. Without the data the table says so."""
    robot = load_robot("kuka_kr300")
    try:
        files = fetch("kuka_kr300", download=False)
    except LogError as error:
        return StudyResult([], notes=[f"skipped: {error}"])
    raw = [import_log([file], shipped_mapping("kuka_kr300"), robot) for file in files]
    skews = [encoder_skews(robot, log) for log in raw]
    progress(0.5)
    delays = [_common(found) for found in skews]
    mended = [
        without_skew(log, _everywhere(found, d))[0] for log, found, d in zip(raw, skews, delays, strict=True)
    ]
    right = [_balance(robot, mended[0], mended[1], k) for k in (1, 2, 3)]
    ignored = [_balance(robot, raw[0], raw[1], k) for k in (1, 2, 3)]
    progress(1.0)
    table = pd.DataFrame(
        {
            "k, MN m/rad": [b.k / 1e6 for b in right],
            "from": [b.lower / 1e6 for b in right],
            "to": [b.upper / 1e6 for b in right],
            "authors": [k / 1e6 for k in AUTHORS],
            "viscous, N m s/rad": [b.viscous for b in right],
            "k with the delay ignored": [b.k / 1e6 for b in ignored],
            "viscous with the delay ignored": [b.viscous for b in ignored],
            "error on A, %": [b.error for b in right],
            "error on B, %": [b.other for b in right],
        },
        index=[f"axis {k}" for k in (1, 2, 3)],
    )
    summary = (
        "Drive stiffness of a KUKA KR300 from motor and link encoders; run A identifies, run B validates."
    )
    page = write_page(folder / "index.html", "KUKA KR300", summary, [Section("Stiffness", table=table)])
    return StudyResult([*_skew_rows(delays), *_rows(right, ignored)], [page])


def _common(skews: list[Skew]) -> Skew:
    """The delay of a run: the mean of its axes by their precision; it is one clock's."""
    weights = np.array([1 / s.std**2 for s in skews])
    mean = float(weights @ [s.delay for s in skews] / weights.sum())
    return Skew(0, mean, float(weights.sum() ** -0.5))


def _everywhere(skews: list[Skew], common: Skew) -> list[Skew]:
    return [Skew(s.joint, common.delay, common.std) for s in skews]


def _equations(robot: Robot, log: Log, k: int) -> tuple[np.ndarray, np.ndarray]:
    part = condition(log, robot)
    m, eps = part.motion, robot.coordinates.index(f"joint{k}.eps[1]")
    de = m.dq[:, k - 1]
    A = np.column_stack([-m.q[:, eps], m.ddq[:, k - 1], np.sign(de), de, np.ones(len(de))])
    return thin(A, part.thinning), thin(part.target[:, k - 1], part.thinning)


def _balance(robot: Robot, log: Log, other: Log, k: int) -> Balance:
    A, y = _equations(robot, log, k)
    p, std = _fit(A, y)
    twist, twist_std = _fit(np.column_stack([y, A[:, 1:]]), -A[:, 0])
    upper = -1 / twist[0] + 1.96 * twist_std[0] / twist[0] ** 2
    B, z = _equations(robot, other, k)
    return Balance(
        k=float(p[0]),
        lower=float(p[0] - 1.96 * std[0]),
        upper=float(upper),
        viscous=float(p[3]),
        error=float(100 * np.linalg.norm(y - A @ p) / np.linalg.norm(y)),
        other=float(100 * np.linalg.norm(z - B @ p) / np.linalg.norm(z)),
    )


def _fit(A: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and standard deviations under residuals that are correlated in time."""
    scale = np.linalg.norm(A, axis=0)
    fit = OLS(y, A / scale).fit(cov_type="HAC", cov_kwds={"maxlags": _LAGS})
    return np.asarray(fit.params) / scale, np.asarray(fit.bse) / scale


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


def _rows(right: list[Balance], ignored: list[Balance]) -> list[dict[str, str]]:
    rows = []
    for k, (b, wrong, theirs) in enumerate(zip(right, ignored, AUTHORS, strict=True), start=1):
        interval = f"{b.lower / 1e6:.1f} to {b.upper / 1e6:.1f} MN m/rad"
        inside = "inside" if b.lower <= theirs <= b.upper else "outside"
        told = f"{interval}; the authors' {theirs / 1e6:.2f} is {inside}"
        text = told if b.told else "not identifiable from this run"
        rows.append(row(f"axis {k}: stiffness", text))
        rows.append(row(f"axis {k}: torque error on A, on B", f"{b.error:.1f} %, {b.other:.1f} %"))
        text = f"stiffness {wrong.k / 1e6:.2f} MN m/rad, viscous friction {wrong.viscous:.0f} N m s/rad"
        rows.append(row(f"axis {k}: with the delay ignored", f"{text} (with it: {b.viscous:.0f})"))
    return rows
