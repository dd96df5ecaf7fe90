"""Replicas whose torques' noise rises where their log does not show it, as noise may: what stands out beside
these is no slow noise.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.comparison.model_against_replicas import Part
from pyident.comparison.trial import Trial
from pyident.simulation.noise.rise import rise
from pyident.simulation.replica import torque_spectra


def with_slow_noise(trial: Trial, replicas: Sequence[Sequence[Part]]) -> list[list[Part]]:
    """The same replicas of the judged logs, what is left of their motor sides as slow as noise may be."""
    made_again = {id(r.log): r for r in (*trial.repeats, *trial.paths)}  # paths, where there are any
    spectra = [torque_spectra(made_again[id(judged.log)]) for judged in trial.judged]
    known = [
        np.array([own[n].continued if n in own else 0.0 for n in trial.robot.torques]) for own in spectra
    ]
    return [[_raised(part, own) for part, own in zip(made, known, strict=True)] for made in replicas]


def _raised(part: Part, continued: np.ndarray) -> Part:
    """continued: (joints,) Hz."""
    joints = len(continued)
    frequency = np.fft.rfftfreq(len(part.residual), part.period)
    higher = np.sqrt(rise(np.maximum(frequency, frequency[1])[:, None], continued))

    def slower(left: np.ndarray) -> np.ndarray:
        raised = np.fft.irfft(np.fft.rfft(left[:, :joints], axis=0) * higher, len(left), axis=0)
        return np.hstack([raised * (part.part.use[:, :joints] > 0), left[:, joints:]])

    return replace(part, residual=slower(part.residual), refitted=slower(part.refitted))
