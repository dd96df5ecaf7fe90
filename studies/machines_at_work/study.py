"""Rigid machines at work, whose owners' files know no zero of a torque: what is said of their logs?"""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path as Folder
from typing import Any

import numpy as np

from pyident.sweep.kept_results import write_json
from pyident.sweep.studies import StudyResult, row

from ..foreign_logs.cases import Case
from ..foreign_logs.closed_loop import Hidden, loop_noise, simulated
from ..foreign_logs.generator import Made, NotDrawn, Truth, hidden_in, laws_of
from ..foreign_logs.kept_cases import solved, written
from ..foreign_logs.machines import drawn_machine, owners_file
from ..foreign_logs.methods import Answer, said_of
from ..foreign_logs.oracle import Oracle
from ..foreign_logs.scoring import (
    OURS,
    Scored,
    counted,
    findings_right,
    is_alarm,
    is_found,
    is_wrong,
    of_diagnosis,
)
from ..foreign_logs.sensors import drawn_sensors, noise_of, recorded, with_columns
from .paths import STYLES, drawn_path

SEED, CASES = 2171, 36
KINDS = ("null", "strong", "medium", "null", "pair", "strong")
RATES = (100, 125, 200)  # Hz
DURATION = 60.0  # s, of either log
ZEROS = 0.2  # of a torque's rms: the largest zero of its channel
_MACHINES = 30


def run(
    folder: Folder, progress: Callable[[float], None], seed: int = SEED, cases: int = CASES
) -> StudyResult:
    """Make, diagnose and count; answers that `folder` has of this seed are kept."""
    listed, where = case_list(seed, cases), folder.absolute() / f"seed_{seed}"
    opened = solved(_solve, listed, where, progress)
    lines = [_line(case, content) for case, content in zip(listed, opened, strict=True)]
    scored = of_diagnosis(listed, opened)
    return StudyResult(table(scored), written(where, lines))


def case_list(seed: int, count: int) -> list[Case]:
    """The first `count` cases of a seed; more cases begin with the same ones."""
    return [_case(seed, i) for i in range(count)]


def _case(seed: int, number: int) -> Case:
    rate = int(np.random.default_rng([seed, number]).choice(RATES))
    kind = KINDS[number % len(KINDS)]
    return Case(f"{number + 1:03d}", (seed, number), kind, False, True, rate, DURATION, False, False)


def made(case: Case) -> Made:
    """Draws until a loop holds its machine."""
    for _ in range(_MACHINES):
        try:
            return _made(case, case.rng)
        except (FloatingPointError, NotDrawn):
            case = replace(case, seed=(case.seed[0], case.seed[1] + 100_000))
    raise RuntimeError(f"case {case.id}: none of {_MACHINES} machines will do; take another seed")


def _made(case: Case, rng: np.random.Generator) -> Made:
    machine = drawn_machine(rng)
    n, oracle, style = len(machine.rotor), Oracle(machine), str(rng.choice(STYLES))
    sensors = drawn_sensors(rng, False, 1 / case.rate)
    paths = [drawn_path(rng, machine.sliders, DURATION, style) for _ in range(2)]
    instants = np.arange(0, DURATION, 1 / case.rate)
    q, v, a = paths[0].at(instants)
    state = oracle.state(instants, q, v, a)
    level = np.sqrt(np.mean(np.square(oracle.plain(state, a)), axis=0))
    every = round(1000 / case.rate)
    fast = loop_noise(simulated(machine, paths[0], [], sensors, 5.0, every)[2], 1 / case.rate)
    noise = np.hypot(noise_of(sensors, level), fast)
    hidden: list[Hidden] = []
    truth: list[Truth] = []
    for law in laws_of(rng, case.kind):
        taken = [h.joint for h in hidden]
        h, found = hidden_in(rng, law, case.kind, oracle, state, a, noise, taken)
        hidden.append(h)
        truth.append(found)
    zeros = level * rng.uniform(-ZEROS, ZEROS, n) * (rng.random(n) < 0.5)
    frames = []
    for path in paths:
        measured, encoders, torques = simulated(machine, path, hidden, sensors, DURATION, every)
        frames.append(recorded(measured, encoders, torques + zeros, level, sensors, rng))
    robot = with_columns(owners_file(machine, rng, ()).without_effect("offset"), sensors)
    besides = tuple(("offset", k + 1) for k in range(n) if zeros[k])
    return Made(robot, frames[0], frames[1], tuple(truth), besides)


def table(cases: Sequence[Scored]) -> list[dict[str, str]]:
    """One row per count. A zero that is told is right, and none is asked for."""
    said = [(c, c.said(OURS)) for c in cases]

    def of(*kinds: str) -> list[tuple[Scored, Answer]]:
        return [(c, a) for c, a in said if c.kind in kinds]

    singles, zeros = of("strong", "medium"), [(name, a) for c, a in said for name in c.besides]
    return [
        counted("false alarm with no law hidden", [is_alarm(c, a) for c, a in of("null")], 5, most=True),
        counted("strong law found", [is_found(c.truth[0], a) for c, a in of("strong")], 95),
        counted("medium law found", [is_found(c.truth[0], a) for c, a in of("medium")], 80),
        counted("one law: a wrong name", [is_wrong(c, a) for c, a in singles], 5, most=True),
        counted("two at once: both", [all(is_found(t, a) for t in c.truth) for c, a in of("pair")], 70),
        counted("zeros of torques told", [any(name in tie for tie in a.ties) for name, a in zeros]),
        counted("findings with one name: right", findings_right(said, lambda tie: len(tie) == 1)),
        counted("findings in a tie: the truth among them", findings_right(said, lambda tie: len(tie) > 1)),
        row("cases that failed", f"{sum(bool(c.failure) for c in cases)} of {len(cases)}"),
    ]


def _solve(_: None, case: Case, folder: Folder) -> None:
    begin, machine = time.perf_counter(), made(case)
    said, failure = said_of(machine)[1:]
    folder.mkdir(parents=True, exist_ok=True)
    content = {"said": asdict(said), "failure": failure, "seconds": time.perf_counter() - begin}
    write_json(folder / f"{case.id}.json", content | machine.sealed)


def _line(case: Case, content: dict[str, Any]) -> dict[str, Any]:
    laws = " + ".join(f"{t['law']}@{t['names'][0][1]} ({t['size']:.1f})" for t in content["truth"])
    names = [" or ".join(f"{e}@{k}" for e, k in tie) for tie in content["said"]["ties"]]
    zeros = " ".join(str(k) for _, k in content["besides"])
    said = " ".join([content["said"]["verdict"], *names])
    return {"id": case.id, "kind": case.kind, "hidden": laws, "zeros": zeros, "said": said}
