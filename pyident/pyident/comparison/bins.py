"""Where a residual stands above its floor: by equation, frequency, speed, load, position, time and so on.

Low frequencies, where physics is, drown in the noise that differences amplify. So each equation's residual is
divided by its floor over frequency and weighed by how far it stands above it there (Wiener's filter), those
of replicas likewise, and sorted into bins.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from flexmodels.coordinate import Coordinate, Side, deformation_of, joint_name, joint_number, motor_of
from flexmodels.robot import Robot
from pyident.comparison.model_against_replicas import Part
from pyident.regression.spectrum import Band, Floor, floor
from pyident.rules.bins import BINS


@dataclass(frozen=True)
class Bin:
    """A part of one equation's residual.

    kind           frequency, speed, load, position, direction, deformation, time, log; all: everything
    label          in words;   low, high: its edges in `unit`
    ratio          rms of the residual over that of replicas
    deviations     of ln ratio from that of the replicas, in standard deviations of these
    share          of what exceeds the floor in this equation
    data_share     of the samples (or frequencies) that are in it
    """

    coordinate: str
    balance: Side
    kind: str
    label: str
    low: float
    high: float
    unit: str
    ratio: float
    deviations: float
    share: float
    data_share: float

    @property
    def joint(self) -> str:
        return joint_name(joint_number(self.coordinate))


def breakdown(
    robot: Robot,
    data: Sequence[Part],
    replicas: Sequence[Sequence[Part]],
    names: Sequence[str],
    refitted: bool,
) -> list[Bin]:
    """Every bin of every equation that is used at some sample.

    data       a Part per log;  replicas: the same of each;  names: of the logs
    refitted   judge under what the regression finds, else under the model's own parameters
    """
    sets = [data, *replicas]
    left = [[p.refitted if refitted else p.residual for p in parts] for parts in sets]
    level = _floor(replicas, left[1:])
    spectra = [_spectra(parts, r, level) for parts, r in zip(sets, left, strict=True)]
    found: list[Bin] = []
    for c, coordinate in enumerate(robot.coordinates):
        if not any(part.part.use[:, c].any() for part in data):
            continue  # its joint stands still: friction is not known at any sample
        bands = _band_bins(coordinate, data, c, spectra)
        found += bands
        found += _state_bins(robot, c, sets, spectra, bands, names)
    return found


def mean_square_over_floor(
    data: Sequence[Part], replicas: Sequence[Sequence[Part]], rows: Sequence[int]
) -> float:
    """Of the residual of some equations, each over its floor at every frequency; 1 is the floor."""
    level = replica_floor(replicas)
    spectra = _spectra(data, [p.residual for p in data], level)
    return float(np.mean(np.concatenate([np.abs(S[:, list(rows)]) ** 2 for _, S in spectra])))


def replica_floor(replicas: Sequence[Sequence[Part]]) -> Floor:
    """What replicas leave of every equation over frequency, under the model's own parameters."""
    return _floor(replicas, [[p.residual for p in parts] for parts in replicas])


def _floor(replicas: Sequence[Sequence[Part]], left: Sequence[Sequence[np.ndarray]]) -> Floor:
    bands = [band_of(p) for made in replicas for p in made]
    residuals = [r for made in left for r in made]
    return floor(bands, [band.transform(r).T for band, r in zip(bands, residuals, strict=True)])


def band_of(part: Part) -> Band:
    """The frequencies at which the equations are sound."""
    samples = len(part.residual)
    length = int(next_fast_len(samples, real=True))  # pyright: ignore[reportArgumentType]
    top = BINS.top * 0.5 / part.period / part.part.thinning
    return Band(length, max(2, int(top * length * part.period)), part.period)


Row = tuple[str, str, float, float, str]  # kind, label, low, high, unit
Spectrum = tuple[Band, np.ndarray]  # (bins, n) complex, over the floor


def _spectra(parts: Sequence[Part], left: Sequence[np.ndarray], level: Floor) -> list[Spectrum]:
    found = []
    for p, r in zip(parts, left, strict=True):
        band = band_of(p)
        S = np.asarray(rfft(r, band.length, axis=0))[: band.bins] / np.sqrt(band.length)
        found.append((band, S / level.at(band)[:, : band.bins].T))
    return found


def _band_bins(
    coordinate: str, data: Sequence[Part], c: int, spectra: Sequence[Sequence[Spectrum]]
) -> list[Bin]:
    frequencies = np.concatenate([band_of(p).frequencies for p in data])
    at = np.digitize(frequencies, BINS.edges) - 1
    energies = [np.concatenate([np.abs(S[:, c]) ** 2 for _, S in parts]) for parts in spectra]
    masks, rows = [], []
    highs = (*BINS.edges[1:], float(frequencies.max()))
    for i, (low, high) in enumerate(zip(BINS.edges, highs, strict=True)):
        if (at == i).sum() >= BINS.lines:
            label = f"below {high:g} Hz" if i == 0 else f"at {low:g} to {high:.3g} Hz"
            masks.append(at == i)
            rows.append(("frequency", label, low, high, "Hz"))
    table = np.array([[_mean(e, m) for m in masks] for e in energies])
    return _judged(coordinate, rows, table, np.array([m.sum() for m in masks]))


def _state_bins(
    robot: Robot,
    c: int,
    sets: Sequence[Sequence[Part]],
    spectra: Sequence[Sequence[Spectrum]],
    bands: Sequence[Bin],
    names: Sequence[str],
) -> list[Bin]:
    """Bins over the state of the joint, those of replicas with the edges that the data have."""
    states = [_states(robot, c, parts) for parts in sets]
    edges = {key: _edges(key, values) for key, values in states[0].items()}
    rows = [row for key in edges for row in _rows(robot, c, key, edges[key], names)]
    masks = [[m for key in edges for m in _masks(state[key], edges[key])] for state in states]
    squares = [_filtered(S, c, parts, bands) for S, parts in zip(spectra, sets, strict=True)]
    table = np.array([[_mean(e, m) for m in listed] for e, listed in zip(squares, masks, strict=True)])
    counts = np.array([m.sum() for m in masks[0]])
    kept = np.all(table > 0, axis=0).tolist()
    return _judged(
        robot.coordinates[c],
        [row for row, k in zip(rows, kept, strict=True) if k],
        table[:, kept],
        counts[kept],
    )


def _mean(squares: np.ndarray, mask: np.ndarray) -> float:
    return float(squares[mask].mean()) if mask.any() else 0.0


def _filtered(spectra: Sequence[Spectrum], c: int, parts: Sequence[Part], bands: Sequence[Bin]) -> np.ndarray:
    """Squares over the used samples of the residual behind Wiener's filter."""
    out = []
    for (band, S), p in zip(spectra, parts, strict=True):
        gain = np.full(band.bins, BINS.least_gain)
        for b in bands:
            inside = (band.frequencies >= b.low) & (band.frequencies <= b.high)
            gain[inside] = max(BINS.least_gain, 1 - 1 / max(b.ratio, 1e-9) ** 2)
        full = np.zeros(band.length // 2 + 1, complex)
        full[: band.bins] = S[:, c] * gain
        over_time = np.asarray(irfft(full * np.sqrt(band.length), band.length))[: len(p.residual)]
        out.append(over_time[p.part.use[:, c] > 0] ** 2)
    return np.concatenate(out)


def _states(robot: Robot, c: int, parts: Sequence[Part]) -> dict[str, np.ndarray]:
    """What the bins are over: of the equation's joint, at the used samples of all logs."""
    found = []
    for number, p in enumerate(parts):
        used = p.part.use[:, c] > 0
        listed = _states_of(robot, c, p) | {"log": np.full(len(used), float(number))}
        found.append({key: values[used] for key, values in listed.items()})
    return {key: np.concatenate([f[key] for f in found]) for key in found[0]}


def _states_of(robot: Robot, c: int, part: Part) -> dict[str, np.ndarray]:
    motion = part.part.motion
    assert motion.time is not None
    coordinates = robot.coordinates
    k = joint_number(coordinates[c])
    motor, joint = coordinates.index(motor_of(k)), robot.joints[k - 1]
    v = motion.dq[:, motor]
    found = {"all": np.zeros(len(v)), "speed": np.abs(v), "direction": v, "position": motion.q[:, motor]}
    if joint.flexible:
        twist = coordinates.index(deformation_of(k))
        found["load"] = np.abs(joint.values["stiffness"]["k[1]"] * motion.q[:, twist])
        found["deformation"] = motion.q[:, twist if c == motor else c]
    else:
        found["load"] = np.abs(part.loads[:, k - 1])
    return found | {"time": motion.time - motion.time[0]}


def _edges(key: str, values: np.ndarray) -> np.ndarray:
    if key in ("all", "log"):
        return np.arange(np.round(values.max()) + 2) - 0.5
    if key == "direction":
        return np.array([-np.inf, 0.0, np.inf])
    if key == "time":
        return np.linspace(0, values.max(), BINS.pieces + 1)
    inner = [float(f"{x:.2g}") for x in np.quantile(values, BINS.quantiles)[1:-1]]
    return np.unique([-np.inf, *inner, np.inf])


def _masks(values: np.ndarray, edges: np.ndarray) -> Iterator[np.ndarray]:
    at = np.digitize(values, edges) - 1
    return (at == i for i in range(len(edges) - 1))


def _rows(robot: Robot, c: int, key: str, edges: np.ndarray, names: Sequence[str]) -> Iterator[Row]:
    k = joint_number(robot.coordinates[c])
    turns = robot.joints[k - 1].kind == "revolute"
    angle, force = ("rad", "N m") if turns else ("m", "N")
    unit = {"speed": f"{angle}/s", "direction": f"{angle}/s", "position": angle, "load": force}.get(key, "")
    unit = "s" if key == "time" else "rad" if key == "deformation" else unit
    for i, (low, high) in enumerate(pairwise(edges)):
        yield key, _label(key, low, high, unit, i, names), float(low), float(high), unit


def _label(key: str, low: float, high: float, unit: str, i: int, names: Sequence[str]) -> str:
    if key == "all":
        return ""
    if key == "log":
        return f"in {names[i]}"
    if key == "direction":
        return "moving backward" if i == 0 else "moving forward"
    word = {"speed": "", "load": "load ", "position": "position ", "deformation": "deformation "}.get(key, "")
    if key == "time":
        return f"from {low:.3g} to {high:.3g} s"
    if np.isinf(low):
        return f"{word}below {high:.2g} {unit}"
    return f"{word}above {low:.2g} {unit}" if np.isinf(high) else f"{word}{low:.2g} to {high:.2g} {unit}"


def _judged(coordinate: str, rows: Sequence[Row], found: np.ndarray, counts: np.ndarray) -> list[Bin]:
    """Bins from mean squares (1 + B, bins): of the data, then of the replicas."""
    data, level = found[0], np.maximum(found[1:].mean(axis=0), 1e-300)
    variance = np.var(np.log(np.maximum(found[1:], 1e-300) / level), axis=0, ddof=1)
    spread = np.sqrt((variance + variance.mean()) / 2) + BINS.least_spread  # few replicas: lean on all bins
    kinds = np.array([row[0] for row in rows])
    over = np.maximum(data - level, 0) * counts
    bins = []
    for i, (kind, label, low, high, unit) in enumerate(rows):
        alike = kinds == kind
        bins.append(
            Bin(
                coordinate,
                Coordinate.parse(coordinate).side,
                kind,
                label,
                low,
                high,
                unit,
                ratio=float(np.sqrt(data[i] / level[i])),
                deviations=float(np.log(max(data[i], 1e-300) / level[i]) / spread[i]),
                share=float(over[i] / max(over[alike].sum(), 1e-300)),
                data_share=float(counts[i] / counts[alike].sum()),
            )
        )
    return bins
