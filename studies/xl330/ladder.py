"""The ladder M1 to M6 that its authors fitted to such servos, refitted here on the same logs.

M1 Coulomb and viscous, M2 with Stribeck, M3 with load, M4 with both, M5 with load by direction, M6 with its
square at standstill; Duclusaud, Passault, Padois and Ly, Extended friction models for the physics simulation
of servo actuators, 2024. Simulated as they do: steps of 5 ms, friction clipped at the stopping torque.
"""

import ctypes
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from flexmodels.compiling.compiler import compiler

STEP = 0.005  # [s]
_ROUGH = 0.03  # [rad], as in the fit that it is compared with
_SOURCE = Path(__file__).parent / "ladder.c"
_PLACES = (
    "kt", "R", "J", "offset", "delay", "coulomb", "viscous", "stribeck", "speed", "curve",
    "external", "motor", "external_slow", "motor_slow", "external_square", "motor_square",
)  # fmt: skip
_RANGES = {  # start, lower, upper
    "kt": (0.35, 0.1, 3.0), "R": (4.0, 0.3, 30.0), "J": (0.002, 1e-4, 0.05), "offset": (0.0, -0.1, 0.1),
    "delay": (0.005, 0.0, 0.05), "coulomb": (0.02, 0.0, 0.3), "viscous": (0.005, 0.0, 1.0),
    "stribeck": (0.03, 0.0, 0.3), "speed": (0.2, 0.05, 2.0), "curve": (1.35, 0.5, 10.0),
    "load": (0.1, 0.0, 1.0), "load_slow": (0.05, 0.0, 1.0),
    "external": (0.1, 0.0, 1.0), "motor": (0.1, 0.0, 1.0),
    "external_slow": (0.05, 0.0, 1.0), "motor_slow": (0.05, 0.0, 1.0),
    "external_square": (0.05, 0.0, 2.0), "motor_square": (0.05, 0.0, 2.0),
}  # fmt: skip
_DRIVE = ("kt", "R", "J", "offset", "delay", "coulomb", "viscous")
_SLOW = ("stribeck", "speed", "curve")
_BOTH_WAYS = ("external", "motor", "external_slow", "motor_slow")
RUNGS = {
    "M1": _DRIVE,
    "M2": (*_DRIVE, *_SLOW),
    "M3": (*_DRIVE, "load"),
    "M4": (*_DRIVE, *_SLOW, "load", "load_slow"),
    "M5": (*_DRIVE, *_SLOW, *_BOTH_WAYS),
    "M6": (*_DRIVE, *_SLOW, *_BOTH_WAYS, "external_square", "motor_square"),
}


@dataclass(frozen=True)
class Track:
    """A log at the ladder's steps: gain [duty/rad], supply [V], reference and position [rad], switch."""

    gain: float
    supply: float
    reference: np.ndarray
    position: np.ndarray
    on: np.ndarray


class Ladder:
    """inertia [kg m2] and weight [N m] of the pendulum; the compiled simulation."""

    def __init__(self, library: Path, inertia: float, weight: float):
        self._simulate = ctypes.CDLL(str(library)).ladder
        self.inertia, self.weight = inertia, weight

    def positions(self, values: dict[str, float], track: Track) -> np.ndarray:
        """[rad], a sample per step."""
        p = np.array([_value(values, name) for name in _PLACES])
        q = np.empty_like(track.position)
        supply = np.full_like(q, track.supply)
        number = ctypes.c_double
        self._simulate(
            _pointer(p), number(self.inertia), number(self.weight), number(track.gain), _pointer(supply),
            _pointer(track.reference), _pointer(track.on), len(q), number(STEP), 1,
            number(track.position[0]), _pointer(q),
        )  # fmt: skip
        return q

    def error(self, values: dict[str, float], tracks: Sequence[Track]) -> float:
        """Mean absolute position error [rad], a mean over logs."""
        errors = [np.abs(self.positions(values, track) - track.position).mean() for track in tracks]
        return float(np.mean(errors))

    def fit(self, rung: str, tracks: Sequence[Track], starts: int = 3) -> dict[str, float]:
        """Robust least squares from several starts; the values with the smallest mean absolute error."""
        names, rng = RUNGS[rung], np.random.default_rng(0)
        begin, lower, upper = (np.array([_RANGES[name][i] for name in names]) for i in range(3))

        def residual(x: np.ndarray) -> np.ndarray:
            values = dict(zip(names, x, strict=True))
            return np.concatenate([self.positions(values, track) - track.position for track in tracks])

        best: dict[str, float] = {}
        for attempt in range(starts):
            spread = rng.uniform(0.4, 2.2, len(names)) if attempt else 1.0
            x = np.clip(begin * spread, lower + 1e-6 * (upper - lower), upper - 1e-6 * (upper - lower))
            scale = np.maximum(begin, 0.02 * (upper - lower))
            found = least_squares(
                residual, x, bounds=(lower, upper), x_scale=scale, loss="soft_l1", f_scale=_ROUGH,
                diff_step=1e-4, max_nfev=60, ftol=1e-5, xtol=1e-6,
            )  # fmt: skip
            values = dict(zip(names, found.x.tolist(), strict=True))
            if not best or self.error(values, tracks) < self.error(best, tracks):
                best = values
        return best


@contextmanager
def compiled(inertia: float, weight: float) -> Iterator[Ladder]:
    """The ladder's C as a library of this machine. Raises BuildError."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "ladder.so"
        command = [*compiler(), "-O2", "-shared", "-fPIC", str(_SOURCE), "-o", str(library), "-lm"]
        subprocess.run(command, check=True, capture_output=True)
        yield Ladder(library, inertia, weight)


def _value(values: dict[str, float], name: str) -> float:
    """M3 and M4 take the load as it is, M5 and M6 its two sides by themselves."""
    if name in values:
        return values[name]
    if name in ("external", "motor"):
        return values.get("load", 0.0)
    if name in ("external_slow", "motor_slow"):
        return values.get("load_slow", 0.0)
    return 1.0 if name in ("speed", "curve") else 0.0


def _pointer(values: np.ndarray):
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
