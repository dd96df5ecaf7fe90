"""What an FMU returns must be numbers."""

import numpy as np
import pandas as pd

from flexmodels.inputs import SimulationError


def require_finite(frame: pd.DataFrame) -> None:
    """Raises SimulationError that names the first value which is none."""
    bad = ~np.isfinite(frame.to_numpy(dtype=float))
    if bad.any():
        row = int(np.argmax(bad.any(axis=1)))
        name = frame.columns[int(np.argmax(bad[row]))]
        raise SimulationError(f"the FMU's {name} is not a finite number at {frame['time'].iloc[row]:.6g} s")
