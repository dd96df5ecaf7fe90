"""One least-squares job in a process of its own: python -m benchmarks.least_squares JOB [SAMPLES]

JOB is a tool or a Parquet log. Prints seconds, peak memory and what the solution predicts as JSON. Imports no
more than the job needs, because its memory counts.
"""

import json
import sys
import time
from typing import Any

import numpy as np
from benchmarks.measure import on_one_core, peak_memory

from flexmodels.files.robot_file import load_robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.samples import Conditioned
from pyident.estimation.least_squares import solve
from pyident.regression.equations import Problem
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor_blocks

TOOLS = ("ours", "numpy lstsq", "scipy lstsq")
_RCOND = 1e-10


def problem(samples: int) -> Problem:
    """A smooth motion of four_link and its torques with noise."""
    robot, rng = load_robot("four_link"), np.random.default_rng(0)
    n, clock = len(robot.coordinates), 0.004 * np.arange(samples)
    w, phase = rng.uniform(1, 30, n), rng.uniform(0, 6, n)
    q, dq, ddq = (np.empty((samples, n)) for _ in range(3))
    for j in range(n):
        angle = w[j] * clock + phase[j]
        q[:, j], dq[:, j] = 0.2 * np.sin(angle), 0.2 * w[j] * np.cos(angle)
        ddq[:, j] = -(w[j] ** 2) * q[:, j]
    motion = Motion(q, dq, ddq)
    p, target = np.array(list(robot.parameters.values())), rng.normal(size=(samples, n))
    for at, Phi in regressor_blocks(robot, motion):
        target[at] += np.einsum("bcp,p->bc", Phi, p)
    return Problem(robot, (Conditioned(motion, target, np.broadcast_to(1.0, target.shape), 1),))


def ours(of: Problem) -> np.ndarray:
    return solve(reduce(of.blocks(), of.rows, of.columns)).p


def stored(of: Problem, tool: str) -> np.ndarray:
    A = np.concatenate([block.copy().reshape(-1, len(of.columns)) for block, _ in of.blocks()])
    y = np.concatenate([block.ravel() for _, block in of.blocks()])
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    A /= scale
    if tool == "scipy lstsq":
        from scipy.linalg import lstsq

        return np.asarray(lstsq(A, y, cond=_RCOND, overwrite_a=True)[0]) / scale  # pyright: ignore
    return np.linalg.lstsq(A, y, rcond=_RCOND)[0] / scale


def job(tool: str, samples: int) -> dict[str, Any]:
    """One run: CPU seconds, peak MB and what the solution predicts."""
    on_one_core()
    of = problem(samples)
    begin = time.process_time()
    p = ours(of) if tool == "ours" else stored(of, tool)
    seconds, peak = time.process_time() - begin, peak_memory()
    _, Phi = next(iter(regressor_blocks(of.robot, of.parts[0].motion)))  # pyright: ignore
    return {"seconds": seconds, "peak MB": peak, "prediction": (Phi[:50] @ p).ravel().tolist()}


def file_job(path: str) -> dict[str, Any]:
    """From the file to the solution."""
    from pyident.conditioning.windows import prepared
    from pyident.logs.disk import log_file

    on_one_core()
    robot = load_robot("four_link")
    begin = time.process_time()
    ours(Problem(robot, (prepared(log_file(path), robot),)))
    return {"seconds": time.process_time() - begin, "peak MB": peak_memory()}


def main() -> int:
    name, *samples = sys.argv[1:]
    print(json.dumps(job(name, int(samples[0])) if name in TOOLS else file_job(name)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
