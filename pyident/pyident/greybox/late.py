"""How late the outputs of a log are, found together with the free parameters.

Parameters that were fitted without a delay have taken over a part of it, and a force that the model has not
looks like one: so the delay of what is suspected to be late is one more free parameter of another fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyident.greybox.candidates import delayed
from pyident.greybox.output_error import OutputError, output_error
from pyident.greybox.recording import Recording, Simulate
from pyident.greybox.residual import Finding, Shown
from pyident.greybox.search import Free
from pyident.rules.greybox import GREYBOX

_NAME = "delay of the log"
_FARTHEST = 64  # samples, as far as a delay is looked for


@dataclass(frozen=True)
class Late:
    """delay [s] of some outputs, by a fit of the free parameters and of the delay."""

    outputs: tuple[str, ...]
    delay: float
    values: Mapping[str, float]
    residuals: tuple[np.ndarray, ...]


def confirmed(
    recordings: Sequence[Recording],
    simulate: Simulate,
    free: Sequence[Free],
    before: Sequence[np.ndarray],
    suspected: Mapping[str, float],
) -> Late | None:
    """The delay of all outputs, else of the suspected ones; None where it does not explain them.

    before      (N, S) per recording: measured less simulated, without a delay
    suspected   output -> its delay [s] as it looks with the parameters as they are
    Raises SimulationError.
    """
    names = recordings[0].outputs
    first = max(suspected, key=lambda name: abs(suspected[name]))
    places = [names.index(name) for name in suspected]
    energy = _energy(before)
    for outputs in dict.fromkeys((names, tuple(n for n in names if n in suspected))):
        fit = _fitted(recordings, simulate, free, outputs, suspected[first])
        share = 1 - _energy(fit.residuals) / np.maximum(energy, np.finfo(float).tiny)
        if (share[places] >= GREYBOX.late).all() and (share >= -GREYBOX.late).all():
            values = dict(fit.values)
            return Late(outputs, values.pop(_NAME), values, fit.residuals)
    return None


def later(simulate: Simulate, outputs: Sequence[str], delay: float | None = None) -> Simulate:
    """The model with some outputs later by `delay` [s], None: by what each set of values says."""

    def run(recording, sets, names, progress=None):
        plain = [{name: v for name, v in s.items() if name != _NAME} for s in sets]
        courses = simulate(recording, plain, names, progress)
        for course, s in zip(courses, sets, strict=True):
            shift = s[_NAME] if delay is None else delay
            for i in (i for i, name in enumerate(names) if name in outputs):
                course[:, i] = delayed(recording.time, course[:, i], shift)
        return courses

    return run


def _fitted(
    recordings: Sequence[Recording],
    simulate: Simulate,
    free: Sequence[Free],
    outputs: Sequence[str],
    delay: float,
) -> OutputError:
    most = _FARTHEST * float(recordings[0].time[1] - recordings[0].time[0])
    own = Free(_NAME, "s", float(np.clip(delay, -most, most)), -most, most)
    return output_error(recordings, later(simulate, outputs), [*free, own])


def _energy(residuals: Sequence[np.ndarray]) -> np.ndarray:
    """(S,)."""
    return np.sum(np.concatenate(residuals) ** 2, axis=0)


def with_delay(before: Shown, rest: Shown, suspicion: Finding | None, late: Late) -> Shown:
    """The output as it was, with the delay and with what is left beside it, as shares of what was left."""
    left = (rest.rms / before.rms) ** 2
    others = tuple(replace(f, share_percent=left * f.share_percent) for f in rest.findings)
    if suspicion is None:
        return replace(before, findings=others)
    size = float(np.sqrt(max(before.rms**2 - rest.rms**2, 0.0)))
    delay = replace(suspicion, at=late.delay, size=size, share_percent=100 * (1 - left))
    return replace(before, findings=(delay, *others))
