"""The paper's section 3: identify the simulated arm, let both models follow a straight line, compare."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.experiment import identification, line
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.robot import Robot
from pyident.estimation.base_parameters import weakest_directions
from pyident.estimation.identify import Identified, identify
from pyident.logs.log import Log, write_log
from pyident.refinement.remove_bias import correct_by_replicas
from pyident.report.page import Picture, Section, write_page
from pyident.simulation.fmu_runs import FmuRuns, simulate_robot
from pyident.sweep.studies import StudyResult, row

from . import derivatives, excitation, identifiability, response, validation


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Simulate, identify, validate; page, figures, identified robots and the log go to `folder`."""
    original = load_robot("four_link")
    plan = identification(original)
    with FmuRuns(original) as runs:
        log = Log(next(iter(runs(plan, [{}]))), "identification")
        progress(0.1)
        regression = identify(original, [log])
        corrected = correct_by_replicas(original, [log], runs, lambda f: progress(0.1 + 0.4 * f))
    write_log(log, folder / "identification.parquet")
    save_robot(regression.robot, folder / "regression.toml")
    save_robot(corrected.robot, folder / "identified.toml")
    progress(0.5)
    models = {"original": original, "regression": regression.robot, "corrected by replicas": corrected.robot}
    wanted = line(original)
    on_line = {name: simulate_robot(robot, wanted) for name, robot in models.items()}
    progress(0.7)
    tip = validation.Tip(original, wanted, on_line)
    schemes = derivatives.compare(original, log)
    bandwidth = excitation.bandwidths(original)
    progress(0.9)
    structural = identifiability.structural_singular_values(original)
    statements = _statements(original, regression, corrected, tip, bandwidth, structural)
    figures = {
        "tip": validation.tip_figure(tip),
        "path": validation.path_figure(tip),
        "torque": validation.torque_figure(tip),
        "singular_values": identifiability.figure(regression, structural),
        "excitation": excitation.spectrum_figure(plan),
        "closed_loop": excitation.closed_loop_figure(bandwidth),
        "response": response.figure(models),
    }
    paths = [folder / f"{name}.png" for name in figures]
    for path, figure in zip(paths, figures.values(), strict=True):
        figure.savefig(path, dpi=130)
    explanation = identifiability.explanation(regression, structural)
    sections = _sections(original, regression, corrected, statements, schemes, explanation, figures)
    factor = min(tip.factor("corrected by replicas", d) for d in validation.DIRECTIONS)
    summary = (
        f"The arm of the paper's figure 1, simulated and identified from {plan.time[-1]:g} s of motion "
        f"without noise. On the validation line the identified model's tip stays {factor:.2g} times closer "
        f"to the original's than the original to the line."
    )
    page = write_page(folder / "index.html", "The seed paper, section 3", summary, sections)
    return StudyResult(statements, [page, *paths])


def _statements(
    original: Robot,
    regression: Identified,
    corrected: Identified,
    tip: validation.Tip,
    bandwidth: dict[str, excitation.Loop],
    structural: np.ndarray,
) -> list[dict[str, str]]:
    """The paper's statements and ours; the first column of `value` is ours."""
    rank, total = regression.solution.rank, len(regression.reduced.columns)
    seen = int((structural > 1e-10 * structural[0]).sum())
    rows = [
        row("parameters", f"{total}", "76", total == 76),
        row(
            "rank in the data",
            f"{rank} (structural rank {seen}, one of it in proportion to eps²)",
            "paper: 64",
        ),
        row(
            "closed-loop bandwidth, joints 1 to 4",
            ", ".join(f"{loop.bandwidth:.1f} Hz" for loop in bandwidth.values()),
            "about 15 Hz",
        ),
    ]
    for name in ("regression", "corrected by replicas"):
        goal = 10 if name == "regression" else 30
        for direction in validation.DIRECTIONS:
            factor = tip.factor(name, direction)
            text = (
                f"{1e3 * tip.difference_rms(name, direction):.2g} mm, {factor:.2g} times below the deviation"
            )
            rows.append(row(f"tip difference, {direction}, {name}", text, f"{goal} times", factor >= goal))
    for k, _ in original.numbered:
        text = f"{tip.torque_difference('corrected by replicas', k):.2g} of {tip.torque_variation(k):.3g} N m"
        factor = tip.torque_variation(k) / max(tip.torque_difference("corrected by replicas", k), 1e-300)
        met = factor >= 30 if tip.torque_variation(k) > 1e-3 else None
        rows.append(row(f"torque difference on the line, joint {k} (rms)", text, "30 times", met))
    for found, name in ((regression, "regression"), (corrected, "corrected by replicas")):
        rows += _errors(original, found, name, strict=name != "regression")
    errors = regression.relative_error
    text = ", ".join(f"{errors[f'joint{k}']:.2f} %" for k, _ in original.numbered)
    met = max(errors.values()) < 1
    rows.append(row("torque residual, joints 1 to 4, regression", text, "1 %", met))
    return rows


_GOALS = {"k[1]": 0.5, "k[2]": 1.0, "k[3]": 1.0, "J_m": 1.0, "coulomb": 2.0, "viscous": 2.0, "d": None}
_WORDS = {
    "k[1]": "drive stiffnesses",
    "k[2]": "bending stiffnesses k2",
    "k[3]": "bending stiffnesses k3",
    "J_m": "motor inertias",
    "coulomb": "Coulomb friction",
    "viscous": "viscous friction",
    "d": "dampings",
}


def _errors(original: Robot, found: Identified, name: str, strict: bool) -> list[dict[str, str]]:
    """Largest error per kind of parameter, of those that the data determine alone."""
    true, rows = original.parameters, []
    for kind, goal in _GOALS.items():
        errors = [
            100 * (found.solution.p[i] / true[p] - 1)
            for i, p in enumerate(found.reduced.columns)
            if p.split(".")[1].startswith(kind) and found.support[p] == "alone"
        ]
        worst = max(np.abs(errors))
        limit = "" if goal is None else f"{goal:g} %"
        met = None if goal is None or not strict else bool(worst <= goal)
        rows.append(row(f"{_WORDS[kind]}, largest error, {name}", f"{worst:.2g} %", limit, met))
    return rows


def _sections(
    original: Robot,
    regression: Identified,
    corrected: Identified,
    statements: list[dict[str, str]],
    schemes: pd.DataFrame,
    explanation: str,
    figures: dict,
) -> list[Section]:
    table = pd.DataFrame(statements).rename(columns={"value": "ours", "goal": "paper or goal"})
    weak = pd.DataFrame({"direction": weakest_directions(regression.reduced, regression.solution)})
    return [
        Section("Statement by statement", table=table),
        Section(
            "Figure 6: the line", pictures=[Picture(figures["path"], "Tip path in the horizontal plane.")]
        ),
        Section(
            "Figure 7: the tip",
            "Above, how far the original's tip leaves the line; below, what differs after identification.",
            [Picture(figures["tip"], "Tip deviation and differences, vertical and horizontal.")],
        ),
        Section(
            "Torques", pictures=[Picture(figures["torque"], "Motor torques on the line and differences.")]
        ),
        Section(
            "Which parameters the data determine",
            explanation,
            [
                Picture(
                    figures["singular_values"], "Singular values, and the rank that a threshold would give."
                )
            ],
            weak,
        ),
        Section(
            "Experiment",
            "204 lines from 0.12 to 50 Hz; nothing above, so that sampling at 250 Hz folds nothing back.",
            [
                Picture(figures["excitation"], "Feed-forward torques and their spectrum."),
                Picture(
                    figures["closed_loop"], "From reference to joint angle: measured on the simulated arm."
                ),
            ],
        ),
        Section("Derivatives and the held torque", derivatives.EXPLANATION, table=schemes),
        Section(
            "Frequency responses",
            "Torque to acceleration of the same joint, every joint at 45° and sliding forward.",
            [Picture(figures["response"], "Original and identified models.")],
        ),
        Section(
            "Parameter by parameter", table=identifiability.parameter_table(original, regression, corrected)
        ),
    ]
