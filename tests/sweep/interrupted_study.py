"""Started by test_parameter_study: a study of slow runs, to be interrupted. Arguments: folder, rows."""

import signal
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from one_joint import one_joint, swing

from pyident.sweep.run import parameter_study
from pyident.sweep.sampling import latin_hypercube


def slowly(log, reference):
    time.sleep(0.01)
    return float(log["joint1.e"].iloc[-1])


def main(folder: str, rows: int) -> None:
    design = latin_hypercube({"joint1.viscous": (1.0, 3.0)}, rows)
    parameter_study(
        design, one_joint(), swing(0.04), folder, metrics={"end": slowly}, workers=2,
        progress=lambda fraction: print(fraction, flush=True),
    )  # fmt: skip


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells start background jobs deaf to it
    try:
        main(sys.argv[1], int(sys.argv[2]))
    except KeyboardInterrupt:
        sys.exit(130)
