"""Φ, eqs (9)-(11): the generalised forces of eq. (8) per unit of every dynamic parameter."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import sympy

from flexmodels.effect import Effect
from flexmodels.robot import Robot, parameter_name
from pyident.link_columns import LinkColumns
from pyident.parallel import spread

CACHED = 1000  # samples at a time: they stay in a core's cache, and no power of two (cache sets collide)
BLOCK = 2 * CACHED


@dataclass(frozen=True)
class Motion:
    """A measured motion over N samples, SI units, columns in the order of `robot.coordinates`.

    q, dq, ddq   N x n;   tau   N x joints, motor torques [N m or N];   time   N [s]
    tau and time are needed only where a law uses them.
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    tau: np.ndarray | None = None
    time: np.ndarray | None = None


@dataclass(frozen=True)
class Regressor:
    """matrix N x n x P; rows are `robot.coordinates` and columns `robot.parameters`, both by name."""

    matrix: np.ndarray
    rows: tuple[str, ...]
    columns: tuple[str, ...]


def regressor(robot: Robot, motion: Motion) -> Regressor:
    """Φ of the whole motion in memory. Raises ValueError for a wrong motion or a law that is not linear."""
    rows, columns = robot.coordinates, tuple(robot.parameters)
    matrix = np.zeros((len(motion.q), len(rows), len(columns)))
    builder = _Builder(robot, motion)
    builder.fill(matrix, 0)
    return Regressor(matrix, rows, columns)


def regressor_blocks(robot: Robot, motion: Motion, block: int = BLOCK) -> Iterator[tuple[slice, np.ndarray]]:
    """Φ piece by piece: (samples, Phi (B, n, P)). Phi is overwritten by the next piece: use or copy it.

    In memory the samples of an entry are neighbours. What is zero in every motion is written once: Phi may
    be scaled in place, but nothing be added to it.

    Raises ValueError as `regressor` does, before the first piece.
    """
    builder = _Builder(robot, motion)
    n, samples = len(robot.coordinates), len(motion.q)
    Phi = np.zeros((n, len(robot.parameters), min(block, samples))).transpose(2, 0, 1)

    def pieces() -> Iterator[tuple[slice, np.ndarray]]:
        for start in range(0, samples, block):
            part = slice(start, min(start + block, samples))
            piece = Phi[: part.stop - start]
            builder.fill(piece, start)
            yield part, piece

    return pieces()


@dataclass(frozen=True)
class _LawColumn:
    """One entry of Φ that a law fills: `value` of the named signals, at (row, column)."""

    row: int
    column: int
    signals: tuple[str, ...]
    value: Callable[..., np.ndarray]


class _Builder:
    """What is known of Φ before the first sample: the structure, where each column stands, the laws."""

    def __init__(self, robot: Robot, motion: Motion):
        self.signals = _signals(robot, motion)
        self.laws = list(_law_columns(robot, frozenset(self.signals)))
        names = list(robot.parameters)
        starts = [names.index(f"link{k}.m") for k, _ in enumerate(robot.links, start=1)]
        self.links = LinkColumns(robot, starts)
        self.rates = [np.ascontiguousarray(rate, float) for rate in (motion.q, motion.dq, motion.ddq)]

    def fill(self, Phi: np.ndarray, start: int) -> None:
        """Write Φ of the samples from `start` on into Phi, which is zero or was filled before."""

        def fill_part(part: slice) -> None:
            piece, samples = Phi[part], slice(start + part.start, start + part.stop)
            q, dq, ddq = (rate[samples] for rate in self.rates)
            self.links.fill(piece, (q, dq, ddq))
            for law in self.laws:
                piece[:, law.row, law.column] = law.value(
                    *(self.signals[name][samples] for name in law.signals)
                )

        spread(fill_part, len(Phi), CACHED)


def _signals(robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
    """Every signal that a law may use, by its name in flexmodels.signals behind `joint{k}.`; and `time`."""
    _check(robot, motion)
    signals = {} if motion.time is None else {"time": np.asarray(motion.time)}
    for j, coordinate in enumerate(robot.coordinates):
        joint, name = _signal_name(coordinate).split(".")
        for order, rate in zip(("", "d", "dd"), (motion.q, motion.dq, motion.ddq), strict=True):
            signals[f"{joint}.{order}{name}"] = rate[:, j]
    if motion.tau is not None:
        signals |= {f"joint{k}.tau": motion.tau[:, k - 1] for k, _ in robot.numbered}
    return signals


def _check(robot: Robot, motion: Motion) -> None:
    n, samples = len(robot.coordinates), len(motion.q)
    shapes = {"q": (samples, n), "dq": (samples, n), "ddq": (samples, n)}
    shapes |= {"tau": (samples, len(robot.joints)), "time": (samples,)}
    for name, shape in shapes.items():
        values = getattr(motion, name)
        if values is None:
            continue
        if np.shape(values) != shape:
            raise ValueError(f"motion.{name} of robot {robot.name} has shape {np.shape(values)}, not {shape}")
        if not np.isfinite(values).all():
            at = int(np.argwhere(~np.isfinite(values))[0, 0])
            raise ValueError(f"motion.{name} of robot {robot.name} is not finite at sample {at}; drop it")


def _law_columns(robot: Robot, known: frozenset[str]) -> Iterator[_LawColumn]:
    """The columns behind those of the links: every parameter of every law of every joint."""
    rows = [_signal_name(coordinate) for coordinate in robot.coordinates]
    names = list(robot.parameters)
    for k, effect in ((k, effect) for k, joint in robot.numbered for effect in joint.effects):
        _require_linear(effect, k)
        for parameter, slopes in effect.columns.items():
            column = names.index(parameter_name(k, effect.name, parameter))
            for coordinate, slope in slopes.items():
                symbols, value = _compiled(slope)
                signals = tuple(name if name in known else f"joint{k}.{name}" for name in symbols)
                for name in set(signals) - known:
                    raise ValueError(
                        f"effect {effect.name} at joint {k} needs the signal {name}, which the motion of "
                        f"robot {robot.name} does not have; add the signal or remove the effect"
                    )
                yield _LawColumn(rows.index(f"joint{k}.{coordinate.name}"), column, signals, value)


def _require_linear(effect: Effect, k: int) -> None:
    """Every parameter must have a column, and that free of the law's own parameters."""
    own = {p.symbol for p in effect.parameters}
    for p in sorted(effect.parameters, key=lambda p: p.name in effect.columns):
        slopes = effect.columns.get(p.name)
        if slopes is None or any(law.free_symbols & own for law in slopes.values()):
            raise ValueError(
                f"effect {effect.name} at joint {k} is not linear in its parameter {p.name}, so it has no "
                "column in Phi; fix that parameter before the law enters a linear fit"
            )


@cache
def _compiled(law: sympy.Expr) -> tuple[tuple[str, ...], Callable[..., np.ndarray]]:
    """The signals of a law by name, and the law as a NumPy function of them."""
    symbols = sorted(law.free_symbols, key=str)
    return tuple(str(s) for s in symbols), sympy.lambdify(symbols, law, modules="numpy")


def _signal_name(coordinate: str) -> str:
    """`joint1.eps[2]` of a log is the signal `joint1.eps2` of a law."""
    return coordinate.replace("[", "").replace("]", "")
