"""The tables of docs/importers.md: every tool, both interfaces, FMI 2 and 3, every shipped robot; the SSP.

    cd tests && python -m importers.matrix [../docs/importers.md] [--robots four_link emps] [--tables systems]

Robots with a controller run the identification experiment in closed loop; the plants of the others move under
constant torques that overcome their friction. 2 s in co-simulation, 0.5 s in model exchange. The SSPs of
robots with a controller run the same experiment at several communication steps.
"""

import argparse
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from importers.environment import CannotInstall
from importers.tools import TOOLS, Answer, Tool, ask

import pyident as pi
from flexfmu.foreign.model import FmuModel
from flexfmu.simulate import LoadedFmu
from flexfmu.ssp import export_ssp
from flexmodels.experiment import Experiment, identification
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot

ROBOTS = ("four_link", "parallelogram", "emps", "tx40", "kuka_kr300")
DURATIONS = {"CoSimulation": 2.0, "ModelExchange": 0.5}  # [s]
PERIOD = 0.004  # [s] of the steps of a plant
MOTOR = {"J_m": 0.5, "coulomb": 5.0, "viscous": 2.0}  # of every hinge without a controller, in SI units
TORQUE = 15.0  # beyond what holds a hinge, in SI units
MOVES = 1e-3  # [m or rad]
MATRIX, SYSTEMS = "matrix", "systems"  # the tables' marks on the page
SYSTEM_TOOLS = ("ecos-cs", "libcosim-cs")
PARTS = (1, 2, 4)  # communication steps of a system in one sample of its controller


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
    return f"{error:.0e}, {speed:{'.0f' if speed >= 100 else '.2g'}}×{mark}", (new or [""])[0]


def system_request(ssp: Path, plan: Experiment, parts: int) -> dict:
    """Of an SSP: some communication steps per sample of the plan, over which the inputs are held."""
    steps = parts * (len(plan.time) - 1)
    pairs = (("r", plan.reference), ("tau_ff", plan.feedforward))
    return {
        "fmu": str(ssp),
        "time": [plan.time[1] / parts * i for i in range(steps + 1)],
        "inputs": {
            f"controller::joint{k}.{s}": np.repeat(v, parts)[: steps + 1].tolist()
            for s, u in pairs
            for k, v in enumerate(u.T, start=1)
        },
        "outputs": [f"plant::tip.{axis}" for axis in "xyz"],
    }


def system_rows(answer: Answer, parts: int) -> np.ndarray:
    """(N - 1, 3) the tip after each sample of the plan."""
    return np.column_stack([answer.rows[f"plant::tip.{axis}"] for axis in "xyz"])[parts - 1 :: parts]


def systems(robots: tuple[str, ...]) -> Iterator[str]:
    """Lines of Markdown: the SSP of every robot with a controller, against the single FMU."""
    loops = [robot for robot in map(pi.load_robot, robots) if robot.controller]
    yield (
        "| tool | SSP of | "
        + " | ".join(f"{parts} step{'s' * (parts > 1)} a sample" for parts in PARTS)
        + " |"
    )
    yield "|---" * (2 + len(PARTS)) + "|"
    for robot in loops:
        with tempfile.TemporaryDirectory() as folder:
            fmu = pi.export_fmu(robot, Path(folder) / "arm.fmu")
            ssp = export_ssp(equations(robot), Path(folder) / "arm.ssp")
            plan: Experiment = identification(robot, duration=DURATIONS["CoSimulation"])
            with LoadedFmu(fmu) as loaded:
                own = loaded.simulate(plan)[["tip.x", "tip.y", "tip.z"]].to_numpy()[1:]
            for name in SYSTEM_TOOLS:
                cells = [_system_cell(TOOLS[name], system_request(ssp, plan, m), own, m) for m in PARTS]
                yield f"| {TOOLS[name].title} | {robot.name} | " + " | ".join(cells) + " |"


def _system_cell(tool: Tool, request: dict, expected: np.ndarray, parts: int) -> str:
    with tempfile.TemporaryDirectory() as folder:
        try:
            answer = ask(tool, Path(folder), request)
        except CannotInstall:
            return "not here"
        except AssertionError:
            return "fails"
    error = float(np.abs(system_rows(answer, parts) - expected).max())
    mark = " !" if answer.complaints else ""
    return f"{1e3 * request['time'][1]:g} ms: {error:.1e}, {request['time'][-1] / answer.seconds:.2g}×{mark}"


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
    parser.add_argument("--tables", nargs="+", default=(MATRIX, SYSTEMS), choices=(MATRIX, SYSTEMS))
    given = parser.parse_args()
    for mark, make in {MATRIX: table, SYSTEMS: systems}.items():
        if mark not in given.tables:
            continue
        lines = []
        for line in make(tuple(given.robots)):
            print(line, flush=True)
            lines.append(line)
        if given.page:
            _replace(given.page, mark, "\n".join(lines).rstrip())


def _replace(page: Path, mark: str, table: str) -> None:
    begin, end = f"<!-- {mark} -->", f"<!-- end of {mark} -->"
    text = page.read_text()
    before, after = text.split(begin)[0], text.split(end)[1]
    page.write_text(f"{before}{begin}\n{table}\n{end}{after}")


if __name__ == "__main__":
    main()
