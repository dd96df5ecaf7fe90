"""Any FMU as the model: its parameters from logs, where it fails on them, what its residual shows.

A log's columns are named as the FMU's variables: inputs feed it, outputs are what it has to meet. Each run is
made in a process of its own, so an FMU that crashes or hangs ends in a SimulationError.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from flexfmu.foreign.model import FmuModel, Quantity
from flexfmu.foreign.parent import SILENCE
from flexmodels.robot import RobotError
from pyident.greybox.late import confirmed, later, with_delay
from pyident.greybox.output_error import OutputError, fixed, output_error
from pyident.greybox.recording import Recording, Signals, Simulate, misses, recording, require_numbers
from pyident.greybox.residual import Shown, coloured, shown, standing_out
from pyident.greybox.search import Derivatives, Free
from pyident.logs.log import Log, LogError, check
from pyident.logs.log import read_log as read_plain
from pyident.verbs.fmu.arguments import Interface, Parameters
from pyident.verbs.fmu.results import FmuCompared, FmuDiagnosed, FmuFit
from pyident.verbs.fmu.settable import Values, require_apart, require_settable, require_unfed

Progress = Callable[[float], None]
Data = Log | pd.DataFrame | str | Path
_LARGEST = 60  # signals that a residual is held against
_RADIANS = {"rad": 1.0, "deg": np.pi / 180}  # per unit of an angle


@dataclass(frozen=True)
class _Opened:
    fmu: FmuModel
    recordings: tuple[Recording, ...]
    frames: tuple[pd.DataFrame, ...]
    simulate: Simulate
    values: Values
    notes: tuple[str, ...]


def identify_fmu(
    model: str | Path,
    logs: Data | Sequence[Data],
    parameters: Parameters,
    *,
    values: Values | None = None,
    interface: Interface | None = None,
    time_limit: float = SILENCE,
    progress: Progress | None = None,
) -> FmuFit:
    """Some parameters (or start values of states) of an FMU by output error, with intervals.

    model        path of the FMU
    logs         as in `identify`; columns have the names of the FMU's inputs and outputs
    parameters   their names, or name -> (lowest, highest) or None: the FMU's own minimum and maximum
    values       of other variables, set for good
    interface    "CoSimulation" (inputs held over a sample) or "ModelExchange" (linear between samples)
    time_limit   seconds without a sign of the FMU after which it is stopped
    progress     called with the fraction done
    Raises RobotError for names that cannot be identified, LogError, SimulationError.
    """
    if not parameters:
        raise RobotError(f"{model}: name the parameters to identify, such as parameters=['k']")
    require_apart(parameters, values)
    with _opened(model, logs, values, interface, time_limit) as o:
        free = [_free(o.fmu, name, parameters) for name in parameters]
        fit = output_error(o.recordings, o.simulate, free, progress, _derivatives(o, free))
    if progress:
        progress(1.0)
    first = o.recordings[0]
    means = standing_out([*zip(first.outputs, first.units, strict=True)], fit.residuals)
    return FmuFit(
        o.fmu.title,
        o.recordings,
        fit,
        (*o.notes, *fit.notes, *means, *coloured(first.outputs, fit.residuals)),
    )


def compare_fmu(
    model: str | Path,
    logs: Data | Sequence[Data],
    *,
    values: Values | None = None,
    interface: Interface | None = None,
    time_limit: float = SILENCE,
) -> FmuCompared:
    """Where an FMU's simulated outputs differ from logs.

    values   of variables, instead of the FMU's own
    The others as in `identify_fmu`. Raises RobotError, LogError, SimulationError.
    """
    with _opened(model, logs, values, interface, time_limit) as o:
        left = misses(o.recordings, o.simulate, {})
    return FmuCompared(o.fmu.title, o.recordings, tuple(left), o.notes)


def diagnose_fmu(
    model: str | Path,
    logs: Data | Sequence[Data],
    parameters: Parameters = (),
    *,
    values: Values | None = None,
    interface: Interface | None = None,
    time_limit: float = SILENCE,
    progress: Progress | None = None,
) -> FmuDiagnosed:
    """What an FMU's output residuals show: a delay, the signals they depend on, periodic orders, or noise.

    parameters   fitted first, as in `identify_fmu`; none: the FMU is taken as it is
    The others as in `identify_fmu`. Raises RobotError, LogError, SimulationError.
    """
    require_apart(parameters, values)
    with _opened(model, logs, values, interface, time_limit) as o:
        fit = None
        if parameters:
            free = [_free(o.fmu, name, parameters) for name in parameters]
            fit = output_error(o.recordings, o.simulate, free, _half(progress), _derivatives(o, free))
        outputs, late = _told(o, fit, progress)
    notes = (*o.notes, *(fit.notes if fit else ()), *late)
    return FmuDiagnosed(o.fmu.title, outputs, fit, notes)


def _told(
    o: _Opened, fit: OutputError | None, progress: Progress | None
) -> tuple[tuple[Shown, ...], tuple[str, ...]]:
    """What the outputs show, and notes; a delay is told where a fit together with it confirms it."""
    values = fit.values if fit else {}
    outputs = _examined(o, o.simulate, values, progress)
    suspected = {f.output: f for out in outputs for f in out.findings if f.kind == "delay"}
    if not suspected:
        return outputs, ()
    free = [replace(e.free, start=e.value) for e in fit.estimates] if fit else []
    before = misses(o.recordings, o.simulate, values)
    late = confirmed(o.recordings, o.simulate, free, before, {n: f.at for n, f in suspected.items()})
    if late is None:
        return _examined(o, o.simulate, values, progress, late=False), ()
    moved = later(o.simulate, late.outputs, late.delay)
    rest = _examined(o, moved, late.values, progress, late=False)
    outputs = tuple(
        with_delay(old, new, suspected.get(old.output), late) for old, new in zip(outputs, rest, strict=True)
    )
    fitted = ", ".join(f"{name} = {value:.6g}" for name, value in late.values.items())
    return outputs, (f"fitted together with the delay: {fitted}",) if fitted else ()


def _examined(
    o: _Opened, simulate: Simulate, values: Values, progress: Progress | None, late: bool = True
) -> tuple[Shown, ...]:
    """late: a delay may be told."""
    names = _courses(o)
    runs = [simulate(r, [values], names)[0] for r in o.recordings]
    first = o.recordings[0]
    met = len(first.outputs)
    require_numbers(
        o.recordings, [r.measured - run[:, :met] for r, run in zip(o.recordings, runs, strict=True)]
    )
    courses = {name: [run[:, i] for run in runs] for i, name in enumerate(names)}
    signals = {n: own for n, own in courses.items() if all(np.isfinite(x).all() for x in own)}
    for name in first.inputs:
        signals[name] = [r.inputs[name] for r in o.recordings]
    for name in o.frames[0]:
        if name not in {*signals, *first.outputs} and all(name in frame for frame in o.frames):
            signals[str(name)] = [frame[name].to_numpy(dtype=float) for frame in o.frames]
    listed = o.fmu.quantities
    units = {name: listed[name].unit for name in signals if name in listed}
    angles = {n: [_RADIANS[u] * x for x in signals[n]] for n, u in units.items() if u in _RADIANS}
    times = [r.time for r in o.recordings]
    outputs = []
    for s, (name, unit) in enumerate(zip(first.outputs, first.units, strict=True)):
        simulated = signals[name]
        left = [r.measured[:, s] - y for r, y in zip(o.recordings, simulated, strict=True)]
        outputs.append(shown(name, unit, times, left, simulated, signals, angles, len(first.outputs), late))
        if progress:
            progress(0.5 + 0.5 * (s + 1) / len(first.outputs))
    return tuple(outputs)


def _courses(o: _Opened) -> list[str]:
    """Outputs first, then what else of the FMU moves, as far as it is continuous."""
    outputs = list(o.recordings[0].outputs)
    others = [
        q.name
        for q in o.fmu.quantities.values()
        if q.causality in ("output", "local") and q.continuous and q.name not in outputs
    ]
    return [*outputs, *others[: max(_LARGEST - len(outputs), 0)]]


@contextmanager
def _opened(
    model: str | Path,
    logs: Data | Sequence[Data],
    values: Values | None,
    interface: Interface | None,
    time_limit: float,
) -> Iterator[_Opened]:
    with FmuModel(model, interface, time_limit) as fmu:
        require_settable(fmu, model, values or {})
        quantities = fmu.quantities
        met = [name for name in (*fmu.of("output"), *fmu.of("local")) if name != "time"]
        offered = Signals(
            inputs={name: (values or {}).get(name, quantities[name].start) for name in fmu.of("input")},
            outputs={name: quantities[name].unit for name in met},
        )
        read = [_read(log) for log in _listed(logs)]
        if not read:
            raise LogError("there is no log; give one or more")
        taken = [recording(log, offered) for log in read]
        recordings = tuple(r for r, _ in taken)
        require_unfed(recordings, values or {})
        for r in recordings[1:]:
            if r.outputs != recordings[0].outputs:
                raise LogError(
                    f"{r.source}: its outputs are {', '.join(r.outputs)}, those of {recordings[0].source} "
                    f"{', '.join(recordings[0].outputs)}; give logs with the same columns"
                )

        def simulate(
            recording: Recording,
            sets: Sequence[Values],
            names: Sequence[str],
            progress: Progress | None = None,
        ) -> np.ndarray:
            return fmu.run(recording.time, recording.inputs, sets, names, progress)

        broken = f"{model} breaks the standard ({fmu.flaw}) and is run all the same"
        notes = (*([broken] if fmu.flaw else []), *(note for _, more in taken for note in more))
        frames = tuple(log.frame for log in read)
        yield _Opened(fmu, recordings, frames, fixed(values or {}, simulate), values or {}, notes)


def _free(fmu: FmuModel, name: str, parameters: Parameters) -> Free:
    require_settable(fmu, fmu.title, {name: 0.0})
    quantity: Quantity = fmu.quantities[name]
    if not quantity.continuous or quantity.causality == "input":
        raise RobotError(f"{fmu.title}: {name} is not a continuous parameter, so it cannot be identified")
    low = -np.inf if quantity.minimum is None else quantity.minimum
    high = np.inf if quantity.maximum is None else quantity.maximum
    free = Free(name, quantity.unit, 0.0 if quantity.start is None else quantity.start, low, high)
    given = parameters.get(name) if isinstance(parameters, Mapping) else None
    if given:
        free = replace(free, low=float(given[0]), high=float(given[1]))
        if not free.low < free.high:
            raise RobotError(f"{name}: the lower bound {free.low:g} is not below the upper one {free.high:g}")
    return free


def _derivatives(o: _Opened, free: Sequence[Free]) -> Derivatives:
    """Those that the FMU has by the standard."""
    first = o.recordings[0]
    names = [f.name for f in free if o.fmu.has_sensitivity(f.name, [*first.inputs], first.outputs)]

    def along(recording: Recording, values: Values, steps: Values) -> np.ndarray:
        given = {**o.values, **values}
        return o.fmu.sensitivities(recording.time, recording.inputs, given, steps, recording.outputs)

    return Derivatives(frozenset(names), along)


def _half(progress: Progress | None) -> Progress | None:
    return None if progress is None else lambda share: progress(0.5 * share)


def _listed(logs: Data | Sequence[Data]) -> list[Data]:
    return [logs] if isinstance(logs, Log | pd.DataFrame | str | Path) else list(logs)


def _read(log: Data) -> Log:
    if isinstance(log, str | Path):
        return read_plain(log)
    if isinstance(log, pd.DataFrame):
        return Log.from_frame(log)
    check(log.frame, log.source)
    return log
