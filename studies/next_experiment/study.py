"""Does a designed motion tell two explanations apart, as far as it promised, and better than any variant of
the experiment at hand? Nobody chooses the pairs: they are drawn from the laws that can act at a joint."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

import pyident as pi
from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.inputs import SimulationError
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot, RobotError
from pyident.excitation.rehearsals.rehearsal import others_like, rehearsal
from pyident.excitation.separation.contest import Contest
from pyident.excitation.separation.rivals import Rivals, Suspect, having
from pyident.excitation.variants import variants
from pyident.logs.log import Log
from pyident.sweep.studies import StudyResult, row

from .diagnosed import ALONE, verdicts

CASES = 8
DURATION = 8.0  # s, of every motion
SECONDS = 60.0  # of each search
SPREAD = 0.1
FLOOR = None  # four_link's own experiment, with which it is compared, goes below its base
NOISE = 1e-5  # rad, of every encoder
LOGS = range(7, 13)  # seeds of the noise of each rival's logs
LAWS = ("stribeck", "presliding", "nonlinear_viscous", "load_dependent_friction", "asymmetric_coulomb",
        "backlash", "hardening_stiffness", "gravity_spring", "torque_ripple")  # fmt: skip
LARGER, SETTLED, WITHIN = 5.0, 5.0, 0.2


@dataclass(frozen=True)
class Case:
    """Two suspects at joints of a robot, each of the size that the experiment at hand leaves open."""

    robot: Robot
    pair: tuple[Suspect, Suspect]
    seed: int

    @property
    def name(self) -> str:
        return " or ".join(who.name for who in self.pair)


def run(folder: Path, progress: Callable[[float], None], cases: int = CASES) -> StudyResult:
    """Design, simulate and score `cases` pairs on four_link; the table goes to `folder`."""
    table = []
    for number, case in enumerate(drawn(load_robot("four_link"), cases)):
        table.append(scored(case))
        progress((number + 1) / cases)
        pd.DataFrame(table).to_csv(folder / "next_experiment.csv", index=False)
    found = pd.DataFrame(table)
    notes = [f"{name}: {why}" for name, why in zip(found["case"], found["failure"], strict=True) if why]
    return StudyResult(rows(found), [folder / "next_experiment.csv"], notes)


def drawn(robot: Robot, count: int) -> Iterator[Case]:
    """Pairs of laws at one joint, drawn at random, of sizes that the robot's own experiment hardly shows."""
    rng, made = np.random.default_rng(2026), 0
    with rehearsal(robot) as own:
        log = own.log(identification(robot, duration=DURATION))
    while made < count:
        joint = int(rng.integers(1, len(robot.joints) + 1))
        laws = [str(law) for law in rng.choice(LAWS, 2, replace=False)]
        try:
            pair = tuple(_sized(robot, Suspect(law, joint), log) for law in laws)
        except RobotError:
            continue  # a law that cannot act there
        yield Case(robot, (pair[0], pair[1]), made)
        made += 1


def _sized(robot: Robot, who: Suspect, log: Log) -> Suspect:
    extended = having(robot, who, log)
    size = extended.joints[who.joint - 1].law(who.effect).size.name
    return replace(who, size=extended.parameters[parameter_name(who.joint, who.effect, size)])


def scored(case: Case) -> dict[str, object]:
    """What the designed motion promises and noisy logs keep, beside the best of the variants."""
    noise = dict.fromkeys(case.robot.coordinates, NOISE)
    words = [f"{who.name}={who.size!r}" for who in case.pair]
    try:
        planned = pi.excite(case.robot, separate=words, duration=DURATION, noise=noise, spread=SPREAD,
                            floor=FLOOR, seconds=SECONDS, seed=case.seed)  # fmt: skip
    except (RobotError, SimulationError) as error:
        return {"case": case.name, "failure": str(error)}
    assert planned.promise is not None
    with ExitStack() as stack:
        off = [real(robot, who, case.seed)
               for robot, who in zip(planned.promise.robots, case.pair, strict=True)]  # fmt: skip
        rehearsals = [stack.enter_context(rehearsal(robot)) for robot in off]
        contest = Contest(Rivals(case.robot, case.pair, (off[0], off[1])), rehearsals, noise)
        motions = variants(case.robot, duration=DURATION)
        library = {name: contest.sigmas(plan, LOGS) for name, plan in motions.items()}
        kept = contest.sigmas(planned.plan, LOGS)
        true = case.seed % 2
        before, after = verdicts(case.robot, rehearsals[true], [identification(case.robot, duration=DURATION),
                                 planned.plan], noise, case.pair[true], case.pair[1 - true])  # fmt: skip
    best = max(library, key=lambda name: library[name])
    return {
        "case": case.name,
        "promised": planned.promise.sigmas,
        "achieved": kept,
        "best_variant": library[best],
        "variant": best,
        "truth": case.pair[true].name,
        "named_before": before,
        "named_after": after,
        "size_percent": 100 * planned.design.scale,
        "failure": "",
    }


def real(robot: Robot, who: Suspect, seed: int) -> Robot:
    """The rival as a machine might be: everything is off by up to `SPREAD`, but the law in question."""
    (other,) = others_like(robot, 1, seed=1000 + seed, spread=SPREAD)
    law = {
        parameter_name(who.joint, who.effect, name) for name in robot.joints[who.joint - 1].values[who.effect]
    }
    return other.with_parameters({name: robot.parameters[name] for name in law})


def rows(found: pd.DataFrame) -> list[dict[str, str]]:
    """The shares that the study is judged by."""
    ran = found.loc[found["failure"] == ""]
    promised, achieved, best = (
        ran[name].to_numpy(float) for name in ("promised", "achieved", "best_variant")
    )
    if not len(ran):
        return [row("motions designed", "0", str(len(found)), False)]
    ratio, near = achieved / best, np.abs(achieved / promised - 1) <= WITHIN
    alone = (ran["named_after"] == ALONE).to_numpy()
    settled, middle = achieved >= SETTLED, float(np.median(ratio))
    return [
        row("motions designed", f"{len(ran)} of {len(found)}", str(len(found)), len(ran) == len(found)),
        row("over the best variant, median", f"{middle:.3g}", f">= {LARGER:g}", middle >= LARGER),
        row("over the best variant, least", f"{ratio.min():.3g}"),
        row("achieved within 20 % of the promise", _share(near), "80 %", bool(near.mean() >= 0.8)),
        row("told apart by 5 deviations", _share(settled), "80 %", bool(settled.mean() >= 0.8)),
        row("law named alone, from the experiment", _share((ran["named_before"] == ALONE).to_numpy())),
        row("law named alone, with the designed motion", _share(alone), "80 %", bool(alone.mean() >= 0.8)),
    ]


def _share(holds: np.ndarray) -> str:
    return f"{np.count_nonzero(holds)} of {len(holds)}"
