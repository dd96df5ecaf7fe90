"""Many runs over the same times in one call of an FMU of ours; see runtime/batch/batch.h."""

import ctypes
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType

import numpy as np

from flexmodels.inputs import SimulationError

_DOUBLES, _UINTS, _INTS, _LONGS = (
    ctypes.POINTER(t) for t in (ctypes.c_double, ctypes.c_uint, ctypes.c_int, ctypes.c_longlong)
)
_STOP = ctypes.CFUNCTYPE(ctypes.c_int, *(ctypes.c_longlong,) * 3)
WHY_LOST = {
    1: "the state left the finite numbers: reduce solver.step or check the parameters",
    2: "friction chatters, and would for many times as long: reduce solver.step or check the parameters",
}  # by `Lost` of batch.h
_SILENT, _LOOKS = 64, 100  # samples between two reports as in batch.c, and looks at the rows of a run
_MESSAGE = 512


class _Batch(ctypes.Structure):
    """`Batch` of runtime/batch/batch.h."""

    _fields_ = (
        *((name, ctypes.c_longlong) for name in ("runs", "samples", "parameters", "outputs")),
        ("time", _DOUBLES),
        ("inputs", _DOUBLES),
        ("experiment", _LONGS),
        ("parameter", _UINTS),
        ("value", _DOUBLES),
        ("noise", _DOUBLES),
        ("output", _UINTS),
        ("row", _DOUBLES),
        ("lost", _INTS),
        ("stop", _STOP),
        ("text", ctypes.c_char_p),
        ("text_size", ctypes.c_longlong),
        ("scalar", ctypes.c_longlong),
    )


class BatchBinary:
    """The batch entry of an FMU's binary, a context manager. Raises OSError or AttributeError without one.

    inputs, joints   numbers of inputs per sample and of joints;  width   runs that advance side by side
    """

    def __init__(self, library: Path):
        self._library = ctypes.CDLL(str(library))
        sizes = (ctypes.c_int * 3)()
        self._library.flexident_batch_sizes(sizes)
        self.inputs, self.joints, self.width = sizes

    def __enter__(self) -> "BatchBinary":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        import _ctypes

        close = getattr(_ctypes, "dlclose", None) or _ctypes.FreeLibrary  # pyright: ignore
        close(self._library._handle)

    def run(
        self,
        time: np.ndarray,
        inputs: np.ndarray,
        experiment: np.ndarray,
        parameters: Sequence[int],
        values: np.ndarray,
        noise: np.ndarray | None,
        outputs: Sequence[int],
        progress: Callable[[float], None] | None = None,
        look: Callable[[int, np.ndarray], None] | None = None,
        scalar: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(runs, samples, outputs), and per run why it was lost, as of WHY_LOST; 0: it was not.

        time     (samples,) [s];  inputs  (experiments, samples, inputs);  experiment  (runs,) of each run
        values   (runs, parameters) by the value references `parameters`
        noise    (runs, samples, joints) added to what the controller measures [rad or m]
        outputs  value references
        progress, look  called now and then with the fraction done, and with the number of a run and its rows
                 so far; what they raise ends all runs
        scalar   one run after the other, for comparison
        Raises SimulationError.
        """
        runs, samples = len(values), len(time)
        rows = np.empty((runs, samples, len(outputs)))
        lost = np.zeros(runs, dtype=np.intc)
        text = ctypes.create_string_buffer(_MESSAGE)
        kept = [np.ascontiguousarray(a, dtype=float) for a in (time, inputs, values)]
        chosen = np.ascontiguousarray(experiment, dtype=np.longlong)
        sensed = None if noise is None else np.ascontiguousarray(noise, dtype=float)
        interrupted: list[BaseException] = []

        def stop(first: int, together: int, done: int) -> int:
            try:
                if progress:
                    progress((first + together * done / samples) / runs)
                if look and done * _LOOKS // samples > (done - _SILENT) * _LOOKS // samples:
                    for run in range(first, first + together):
                        look(run, rows[run, :done])
            except BaseException as error:  # it must not cross the C code
                interrupted.append(error)
                return 1
            return 0

        batch = _Batch(
            runs=runs,
            samples=samples,
            parameters=len(parameters),
            outputs=len(outputs),
            time=_doubles(kept[0]),
            inputs=_doubles(kept[1]),
            experiment=chosen.ctypes.data_as(_LONGS),
            parameter=(ctypes.c_uint * max(1, len(parameters)))(*parameters),
            value=_doubles(kept[2]),
            noise=None if sensed is None else _doubles(sensed),
            output=(ctypes.c_uint * max(1, len(outputs)))(*outputs),
            row=_doubles(rows),
            lost=lost.ctypes.data_as(_INTS),
            stop=_STOP(stop),
            text=ctypes.cast(text, ctypes.c_char_p),
            text_size=_MESSAGE,
            scalar=int(scalar),
        )
        failed = self._library.flexident_batch(ctypes.byref(batch))
        if interrupted:
            raise interrupted[0]
        if failed:
            raise SimulationError(text.value.decode())
        return rows, lost


def _doubles(values: np.ndarray):
    return values.ctypes.data_as(_DOUBLES)
