"""A run by FMPy's own loop, for FMI 3.0 and model exchange; inputs are linear between samples."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from fmpy import instantiate_fmu, simulate_fmu
from fmpy.model_description import ModelDescription

from flexfmu.foreign.access import feed_at_every_instant, linear_feed
from flexmodels.inputs import SimulationError

_TOLERANCE = 1e-8  # of CVode
_SAME = 1e-9  # [s] two instants are one


@dataclass(frozen=True)
class Course:
    """time (N,) [s], evenly spaced; names of inputs and their values (N, inputs)."""

    time: np.ndarray
    names: tuple[str, ...]
    inputs: np.ndarray


def run_by_fmpy(
    folder: str,
    description: ModelDescription,
    course: Course,
    starts: Mapping[str, float],
    outputs: tuple[str, ...],
    progress: Callable[[float], object] | None = None,
) -> np.ndarray:
    """Outputs of an unpacked FMU (N, outputs), at an event what is there after it. Raises SimulationError."""
    time, stop = course.time, float(course.time[-1])
    signals = np.zeros(len(time), dtype=[(name, float) for name in ("time", *course.names)])
    signals["time"] = time
    for name, values in zip(course.names, course.inputs.T, strict=True):
        signals[name] = values
    simulation = description.coSimulation
    kind = "CoSimulation" if simulation else "ModelExchange"
    events = bool(simulation and simulation.hasEventMode)
    messages: list[str] = []
    fmu = None
    try:
        fmu = instantiate_fmu(
            folder,
            description,
            kind,
            logger=lambda *words: messages.append(words[-1].decode("utf-8", "replace")),
            event_mode_used=events,
            early_return_allowed=events,
        )
        if not simulation:
            listed = {v.name: v for v in description.modelVariables}
            fed = [listed[name] for name in course.names]
            feed_at_every_instant(fmu, linear_feed(fmu, fed, time, course.inputs))
        result = simulate_fmu(
            folder,
            model_description=description,
            fmi_type=kind,
            fmu_instance=fmu,
            start_time=float(time[0]),
            stop_time=stop,
            output_interval=float(time[1] - time[0]),
            start_values=dict(starts),
            input=signals,
            output=list(outputs),
            relative_tolerance=None if simulation else _TOLERANCE,  # pyright: ignore[reportArgumentType]
            use_event_mode=events,
            early_return_allowed=events,
            step_finished=lambda now, _: not (progress and progress(now / stop)),
        )
    except Exception as error:
        raise SimulationError(messages[-1] if messages else f"the FMU failed ({error})") from None
    finally:
        if fmu is not None:
            fmu.freeInstance()
    last = np.searchsorted(result["time"], time + _SAME) - 1
    return np.column_stack([result[name][last] for name in outputs])
