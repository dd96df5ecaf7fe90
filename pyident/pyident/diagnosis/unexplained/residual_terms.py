"""The terms of one equation's residual: smooth functions of a signal, waves, a misread angle."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.coordinate import joint_number
from flexmodels.robot import Robot
from pyident.conditioning.order_waves import span_of
from pyident.diagnosis.base.order_peaks import orders_told
from pyident.diagnosis.base.projection import Base, Columns, extended, gain
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.unexplained.periodic import (
    Over,
    Peak,
    Spectrum,
    highest,
    misread_columns,
    periodic_columns,
    spectrum,
)
from pyident.diagnosis.unexplained.smooth import (
    Form,
    Variable,
    constant_columns,
    curve,
    spline_columns,
    variables,
)
from pyident.diagnosis.unexplained.sudden import sudden_change
from pyident.regression.spectrum import Equations
from pyident.rules.confidence import PERIODS


@dataclass(frozen=True)
class Dependence:
    """What one more term explains, on top of those before it.

    coordinate      equation, as in `robot.coordinates`
    on, words       signal or `time`, `joint2.e`; in words
    form            `force` f(x), `friction` sign(v) f(x), `frequency`, `order`, `misread`,
                    `constant`
    share_percent   of all that exceeds the floor
    pretended       gain of the same term in replicas, in energy;  gain: in the data
    x, force        the curve [SI; N m], or the spectrum: frequencies or orders and amplitudes
    at, amplitude   of a peak [Hz or per turn; N m, or rad where an angle is misread], else None; of a step in
                    time its size
    rivals          signals that explain nearly as much, in words;  rival_signals: their names
    """

    coordinate: str
    on: str
    words: str
    form: Form | str
    share_percent: float
    gain: float
    pretended: float
    x: np.ndarray
    force: np.ndarray
    at: float | None = None
    amplitude: float | None = None
    rivals: tuple[str, ...] = ()
    rival_signals: tuple[str, ...] = ()

    @property
    def said(self) -> str:
        return f"friction with {self.words}" if self.form == "friction" else self.words


class RowSearch:
    """The terms of one equation, one after the other.

    row         of the equation, as in `robot.coordinates`
    total       energy of the excess that shares are of
    pretended   (replicas, variables) energies that the splines explain of replicas; none: of noise
    """

    def __init__(
        self,
        examination: Examination,
        base: Base,
        row: int,
        total: float,
        pretended: np.ndarray | None = None,
    ):
        self.robot: Robot = examination.setting.robot
        self.rules = examination.setting.rules.unexplained
        self.periods = examination.setting.rules.periodic
        self.logs, self.levels = examination.logs, examination.levels
        self.sources = [log.source for log in examination.setting.logs]
        self.base, self.row, self.total = base, row, total
        self.variables = variables(self.robot, self.logs, row)
        of_noise = np.array([[float(len(v.knots)) for v in self.variables]])
        self.pretended = of_noise if pretended is None else pretended
        self.spectra: list[Spectrum] = []

    def strongest(self) -> tuple[Dependence, Columns] | None:
        """The term that explains most of the present base, with its columns; None where none is sure."""
        better = [d for d in (self._smooth(), self._periodic()) if d is not None]
        return max(better, key=lambda d: d[0].gain - d[0].pretended, default=None)

    def run(self, floor: np.ndarray) -> list[Dependence]:
        """floor: (n,) energies that replicas leave on the equations."""
        level, share = self._constant()
        found: list[Dependence] = []
        while (
            len(found) < self.rules.terms
            and excess(self.base, floor).sum() > self.rules.material * self.total
        ):
            best = self.strongest()
            if best is None:
                break
            dependence, columns = best
            self.base = extended(self.base, columns)
            found.append(dependence)
        if found and found[0].form == "force":  # its mean is part of it
            first = found[0]
            found[0] = replace(first, share_percent=first.share_percent + share, gain=first.gain + level.gain)
        elif share > 100 * self.rules.material:
            found.append(level)
        return found

    def _constant(self) -> tuple[Dependence, float]:
        """Join a constant force, which no spline may claim for itself, to the base; its share [%]."""
        columns = constant_columns(self.logs, self.levels, self.row)
        explained = gain(self.base, columns)
        self.base = extended(self.base, columns)
        share, size = 100 * explained.energy / self.total, float(explained.coefficients[0])
        coordinate = self.robot.coordinates[self.row]
        words = f"a constant of {size:.3g} N m"
        x, force = np.zeros(1), np.full(1, size)
        return Dependence(coordinate, "", words, "constant", share, explained.energy, 1.0, x, force), share

    def _smooth(self) -> tuple[Dependence, Columns] | None:
        gains = spline_gains(self.base, self.variables, self.logs, self.levels, self.row)
        mean, most = self.pretended.mean(axis=0), self.pretended.max(axis=0)
        beyond = gains - mean
        if beyond.max() <= 0:  # replicas pretend more of every signal
            return None
        near = np.flatnonzero(beyond >= self.rules.tie * beyond.max())
        best = max(near.tolist(), key=lambda i: (self._is_own(i), beyond[i]))
        variable = self.variables[best]
        columns = spline_columns(variable, self.logs, self.levels, self.row)
        K = columns[0][self.row].shape[1]
        if gains[best] < max(
            K + self.rules.sure * np.sqrt(2 * K),
            self.rules.beyond * most[best],
            mean[best] + self.rules.material * self.total,
        ):
            return None
        x, force = curve(variable, gain(self.base, columns).coefficients)
        share = 100 * (gains[best] - mean[best]) / self.total
        smooth = Dependence(
            self.robot.coordinates[self.row],
            variable.name,
            variable.words,
            variable.form,
            float(share),
            float(gains[best]),
            float(mean[best]),
            x,
            force,
            rivals=tuple(_said(self.variables[i]) for i in near if i != best),
            rival_signals=tuple(self.variables[i].name for i in near if i != best),
        )
        return (self._sudden(smooth) if variable.name == "time" else None) or (smooth, columns)

    def _sudden(self, smooth: Dependence) -> tuple[Dependence, Columns] | None:
        """The same, where a step explains as much as a smooth function of time."""
        form: Form = "friction" if smooth.form == "friction" else "force"
        change = sudden_change(self.base, form, self.logs, self.levels, self.row)
        if change is None or change.energy < self.rules.tie * smooth.gain:
            return None
        source = "" if change.log is None else f" of {self.sources[change.log]}"
        share = 100 * (change.energy - smooth.pretended) / self.total
        told = replace(
            smooth,
            words=f"time, from about {change.start:.3g} s{source} on",
            share_percent=share,
            gain=change.energy,
            amplitude=change.size,
        )
        return told, change.columns

    def _is_own(self, variable: int) -> bool:
        """Whether a signal is of the equation's own joint."""
        name = self.variables[variable].name
        return name == "travel" or (name != "time" and joint_number(name) == self.robot.q[self.row].joint)

    def _periodic(self) -> tuple[Dependence, Columns] | None:
        data = self.base, self.logs, self.levels
        found = [spectrum(*data, over, self.periods) for over in _overs(self.robot, self.row)]
        self.spectra = self.spectra or found
        peaks = [(highest(*data, s, self.periods), s) for s in found]
        counted = [(p, s) for p, s in peaks if p is not None and p.p_value < self.rules.level]
        if not counted:
            return None
        peak, of = max(counted, key=lambda pair: pair[0].energy)
        if peak.energy < self.rules.material * self.total:
            return None
        if peak.over.kind == "misread":
            return self._misread(peak, of)
        return self._of_peak(peak, of), periodic_columns(self.logs, self.levels, peak.over, peak.at)

    def _misread(self, peak: Peak, of: Spectrum) -> tuple[Dependence, Columns]:
        """The error of an angle acts on every equation."""
        column = peak.over.column

        def columns(order: float) -> Columns:
            return misread_columns(self.robot, self.base.p, self.logs, self.levels, column, order)

        whole = gain(self.base, columns(peak.at))
        size = float(np.linalg.norm(whole.coefficients))
        exact = replace(peak, energy=max(whole.energy, peak.energy), amplitude=size)
        return self._of_peak(exact, of), columns(peak.at)

    def _of_peak(self, peak: Peak, of: Spectrum) -> Dependence:
        over = peak.over
        on = "time" if over.kind == "frequency" else self.robot.coordinates[over.column]
        joint = self.robot.q[over.column].joint
        words = {
            "frequency": f"a frequency of {peak.at:.4g} Hz in time",
            "order": f"an order of {orders_told(self.robot, joint, [peak.at])} of joint {joint}"
            + self._too_few(over, peak.at),
            "misread": f"a misread angle of joint {joint}, {peak.at:.4g} times a turn",
        }[over.kind]
        return Dependence(
            self.robot.coordinates[self.row],
            on,
            words,
            over.kind,
            100 * peak.energy / self.total,
            peak.energy,
            0.0,
            of.at,
            of.amplitude,
            peak.at,
            peak.amplitude,
        )

    def _too_few(self, over: Over, order: float) -> str:
        """That a log passes too few periods of an order to call it a ripple; empty: it passes enough."""
        passed = order * span_of([log.part.motion.q[:, over.column] for log in self.logs]) / (2 * np.pi)
        if passed >= PERIODS:
            return ""
        return (
            f", of which no log passes more than {passed:.1f} periods: a ripple needs {PERIODS:g}, to be "
            "told from any other torque of the angle"
        )


def _overs(robot: Robot, row: int) -> list[Over]:
    """What a force on this equation may be periodic in."""
    own = joint_number(robot.coordinates[row]) - 1
    misread = [Over("misread", row, own)] if robot.joints[own].kind == "revolute" else []
    return [Over("frequency", row), *(Over("order", row, k) for k in range(len(robot.joints))), *misread]


def excess(base: Base, floor: np.ndarray) -> np.ndarray:
    """(n,) energy above the floor on each equation; one that lies below takes nothing from the others."""
    left = np.sum([np.square(residual).sum(axis=1) for residual in base.residual], axis=0)
    return np.maximum(left - floor, 0.0)


def spline_gains(
    base: Base, listed: Sequence[Variable], logs: Sequence[Equations], levels: Sequence[np.ndarray], row: int
) -> np.ndarray:
    """(variables,) energy that each variable's splines explain of the base's residual on one equation."""
    out = []
    for variable in listed:
        columns = spline_columns(variable, logs, levels, row)
        out.append(gain(base, columns).energy)
    return np.array(out)


def _said(variable: Variable) -> str:
    return f"friction with {variable.words}" if variable.form == "friction" else variable.words
