"""The table of docs/importers.md: every tool, both interfaces, FMI 2 and 3, every shipped robot.

    cd tests && python -m importers.matrix [../docs/importers.md] [--robots four_link emps]

Robots with a controller run the identification experiment in closed loop; the plants of the others move under
constant torques that overcome their friction. 2 s in co-simulation, 0.5 s in model exchange.
"""

import argparse
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from importers.environment import CannotInstall
from importers.tools import TOOLS, Tool, ask

import pyident as pi
from flexfmu.foreign.model import FmuModel
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment, identification
from flexmodels.robot import Robot

ROBOTS = ("four_link", "parallelogram", "emps", "tx40", "kuka_kr300")
DURATIONS = {"CoSimulation": 2.0, "ModelExchange": 0.5}  # [s]
PERIOD = 0.004  # [s] of the steps of a plant
MOTOR = {"J_m": 0.5, "coulomb": 5.0, "viscous": 2.0}  # of every hinge without a controller, in SI units
TORQUE = 15.0  # beyond what holds a hinge, in SI units
MOVES = 1e-3  # [m or rad]
BEGIN, END = "<!-- matrix -->", "<!-- end of matrix -->"


@dataclass(frozen=True)
class Case:
    """A robot's FMUs by version of the standard, its requests and what must come out, by interface."""

    fmus: dict[int, Path]
    requests: dict[str, dict]
    expected: dict[str, np.ndarray]


def case(robot: Robot, folder: Path) -> Case:
    part = "arm" if robot.controller else "plant"
    names = [f"joint{k}" for k in range(1, len(robot.joints) + 1)]
    given = {f"{name}.{p}": v for name in names for p, v in MOTOR.items()}
    parameters = {} if robot.controller else given
    fmus = {
        v: pi.export_fmu(robot, folder / f"{robot.name}{v}.fmu", v, part=part, parameters=parameters)
        for v in (2, 3)
    }
    requests, expected = {}, {}
    for interface, duration in DURATIONS.items():
        make = _loop if robot.controller else _pushed
        requests[interface], expected[interface] = make(robot, fmus[2], duration)
        assert np.ptp(expected[interface], axis=0).max() > MOVES
    return Case(fmus, requests, expected)


def _loop(robot: Robot, fmu: Path, duration: float) -> tuple[dict, np.ndarray]:
    plan: Experiment = identification(robot, duration=duration)
    with LoadedFmu(fmu) as loaded:
        own = loaded.simulate(plan)
    outputs = [name for name in ("tip.x", "tip.y", "tip.z") if name in own]
    pairs = (("r", plan.reference), ("tau_ff", plan.feedforward))
    inputs = {f"joint{k}.{s}": v.tolist() for s, u in pairs for k, v in enumerate(u.T, start=1)}
    request = {"time": plan.time.tolist(), "inputs": inputs, "outputs": outputs}
    return request, own[outputs].to_numpy()[1:]


def _pushed(robot: Robot, fmu: Path, duration: float) -> tuple[dict, np.ndarray]:
    time = PERIOD * np.arange(round(duration / PERIOD) + 1)
    joints = range(1, len(robot.joints) + 1)
    outputs = [f"joint{k}.e" for k in joints]
    with FmuModel(fmu) as model:
        holding = model.run(time[:2], {}, [{}], [f"joint{k}.tau_0" for k in joints])[0, 0]
        pushed = zip(joints, holding + TORQUE, strict=True)
        inputs = {f"joint{k}.tau": np.full(len(time), u) for k, u in pushed}
        own = model.run(time, inputs, [{}], outputs)[0]
    fed = {name: values.tolist() for name, values in inputs.items()}
    return {"time": time.tolist(), "inputs": fed, "outputs": outputs}, own[1:]


def cell(tool: Tool, version: int, case: Case) -> tuple[str, str]:
    """Error and speed, or `fails`; and what is to be said of it."""
    request, expected = case.requests[tool.interface], case.expected[tool.interface]
    with tempfile.TemporaryDirectory() as folder:
        try:
            answer = ask(tool, Path(folder), {**request, "fmu": str(case.fmus[version])})
        except CannotInstall as reason:
            return "not here", str(reason)
        except AssertionError as reason:
            lines = [line for line in str(reason).splitlines() if line.strip()] or ["it said nothing"]
            return "fails", lines[-1][:120]
    rows = np.column_stack([answer.rows[name] for name in request["outputs"]])
    error = float(np.abs(rows - expected).max())
    speed = request["time"][-1] / answer.seconds
    known = [line for line in answer.complaints if tool.expected and re.search(tool.expected, line)]
    new = [line for line in answer.complaints if line not in known]
    mark = " !" if new else " *" if known else ""
    return f"{error:.0e}, {speed:.2g}×{mark}", (new or [""])[0]


def table(robots: tuple[str, ...]) -> Iterator[str]:
    """Lines of Markdown."""
    notes: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder:
        cases = {name: case(pi.load_robot(name), Path(folder)) for name in robots}
        heads = [n if pi.load_robot(n).controller else f"{n}, plant" for n in robots]
        yield "| tool | interface | FMI | " + " | ".join(heads) + " |"
        yield "|---" * (3 + len(robots)) + "|"
        for name, tool in TOOLS.items():
            kind = "CS" if tool.interface == "CoSimulation" else "ME"
            kind += " with event mode" if tool.event_mode else ""
            for version in (3,) if tool.event_mode else (2, 3):
                cells = []
                for robot in robots:
                    words, reason = cell(replace(tool, versions=(version,)), version, cases[robot])
                    cells.append(words)
                    if reason:
                        notes.setdefault(f"{name}, FMI {version}: {reason}", robot)
                yield f"| {tool.title} | {kind} | {version} | " + " | ".join(cells) + " |"
    yield ""
    yield from (f"- {note} ({robot})" for note, robot in notes.items())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("page", nargs="?", type=Path, help="whose table is replaced; none: printed only")
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    given = parser.parse_args()
    lines = []
    for line in table(tuple(given.robots)):
        print(line, flush=True)
        lines.append(line)
    if given.page:
        text = given.page.read_text()
        before, after = text.split(BEGIN)[0], text.split(END)[1]
        given.page.write_text(f"{before}{BEGIN}\n" + "\n".join(lines).rstrip() + f"\n{END}{after}")


if __name__ == "__main__":
    main()
