"""Motions for identification of the TX40: condition number of the base regressor, ours beside figaroh's.

    python -m benchmarks.trajectory -o out

Same robot (the shipped tx40 as a URDF: inertias, motor inertias, viscous and Coulomb friction), duration and
rate, limits of position, speed and torque. The condition numbers are those of figaroh's base regressor.
Pinocchio's inverse dynamics says whether the limits are kept, at a rate four times as high. Ours also keep
the links, as capsules, apart, and are as small as 48 robots off by a quarter need it, not so figaroh's.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
from benchmarks.measure import on_one_core
from benchmarks.results import command, drawn, keep
from scipy.interpolate import CubicSpline

import pyident as pi
from flexmodels.files.urdf.importer import import_urdf
from pyident.excitation.rehearsals.rehearsal import reference_of_plan
from pyident.verbs.robots import export_robot

RATE = 50.0  # Hz at which motions are judged
_CLOSER = 4  # times as many samples for the check

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]


def kept(model, motion: Motion) -> bool:
    """Whether positions, speeds and torques keep the model's limits, between the samples, too."""
    import pinocchio as pin  # pyright: ignore[reportMissingImports]

    samples = np.arange(len(motion[0]))
    fine = np.linspace(0, samples[-1], _CLOSER * samples[-1] + 1)
    q, dq, ddq = (CubicSpline(samples, values)(fine) for values in motion)
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *x) for x in zip(q, dq, ddq, strict=True)])
    slack = 1 + 1e-6
    return bool(
        (q <= model.upperPositionLimit + 1e-6).all()
        and (q >= model.lowerPositionLimit - 1e-6).all()
        and (np.abs(dq) <= slack * model.velocityLimit).all()
        and (np.abs(tau) <= slack * model.effortLimit).all()
    )


def ours(urdf: Path, duration: float, seconds: float, criterion: str) -> Motion:
    """As `pyident excite` designs it for the URDF, without a floor."""
    planned = pi.excite(
        import_urdf(urdf), criterion=criterion, duration=duration, rate=RATE, floor=None, seconds=seconds,
        evaluations=1_000_000,
    )  # fmt: skip
    motion = reference_of_plan(planned.plan)
    return motion.q, motion.dq, motion.ddq


def rows(duration: float, seconds: float, iterations: int) -> list[dict[str, object]]:
    """Condition number, limits and time of every tool."""
    import pinocchio as pin  # pyright: ignore[reportMissingImports]
    from benchmarks.peers.figaroh_trajectory import Peer

    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / "tx40.urdf"
        export_robot("tx40", urdf)
        model = pin.buildModelFromUrdf(str(urdf))
        peer = Peer(model, duration, RATE, segments=2, iterations=iterations)
        tools: dict[str, Callable[[], Motion | None]] = {
            "pyident, smallest condition": lambda: ours(urdf, duration, seconds, "condition"),
            "pyident, most information": lambda: ours(urdf, duration, seconds, "information"),
        }
        if find_spec("cyipopt"):
            tools[f"figaroh, {iterations} iterations"] = peer.solve
        else:
            print("note: figaroh's trajectory is left out: cyipopt is missing", file=sys.stderr)
        found = []
        for tool, made in tools.items():
            begun = time.process_time()
            motion = made()
            row: dict[str, object] = {"tool": tool, "CPU seconds": time.process_time() - begun}
            if motion is not None:
                row |= {"condition number": peer.condition(*motion), "limits kept": kept(model, motion)}
            found.append(row)
    return found


def figure(table: pd.DataFrame, path: Path) -> None:
    with drawn(path) as (ax,):
        ax.barh(table["tool"], table["condition number"])
        ax.set(xlabel="condition number of the base regressor")


def main() -> int:
    parser = command(__doc__)
    parser.add_argument("--duration", type=float, default=12.0, help="of the motion [s]")
    parser.add_argument("--seconds", type=float, default=120.0, help="of our search")
    parser.add_argument(
        "--iterations", type=int, default=30, help="of figaroh's IPOPT, in each of two segments"
    )
    given = parser.parse_args()
    on_one_core()
    keep(pd.DataFrame(rows(given.duration, given.seconds, given.iterations)), "trajectory", given.out, figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
