"""Page of an identification: values beside the prior, what they rest on, and what is left of the torques."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from flexmodels.robot import Robot
from pyident.estimation.identify import Identified
from pyident.estimation.residuals import SLOW, JointResidual, correlations
from pyident.report.page import Picture, Section, write_page
from pyident.rules.confidence import CONFIDENCE

_DETERMINED = {"alone": "alone", "combination": "in combination", "no": "not at all"}
_NOTICED = 0.9  # correlation from which on a pair is worth a warning


def write_identification(
    path: Path,
    found: Identified,
    notes: Sequence[str],
    residuals: Sequence[JointResidual],
    heldout: Mapping[str, Mapping[str, float]],
    prior: Robot | None = None,
) -> Path:
    """Write the page. heldout: log -> joint -> error of the written model's torque [%]."""
    sections = [
        Section(
            "Errors",
            "Relative error of the motor torques, 100 |τ − Φp| / |τ|, in per cent: of the estimate, of the "
            "written model (physically consistent), and of that model on logs that it was not fitted to.",
            table=_errors(found, heldout),
        ),
        Section(
            "Parameters",
            "A parameter that the data determine only in combination has no interval of its own; the base "
            "parameters below have theirs.",
            table=_parameters(found, prior),
        ),
        Section("Base parameters", "What the data determine, and how well.", table=_base(found)),
        Section("What acts alike", *_alike(found)),
    ]
    if residuals:
        sections.append(_left(residuals))
    if notes:
        sections.append(Section("Notes", " · ".join(notes)))
    summary = (
        f"{found.estimator}: {len(found.reduced.columns)} parameters, of which the data determine "
        f"{found.solution.rank} combinations; torque error {found.relative_error['all']:.3g} %."
    )
    return write_page(path, found.robot.name, summary, sections)


def _errors(found: Identified, heldout: Mapping[str, Mapping[str, float]]) -> pd.DataFrame:
    columns = {"estimate": found.relative_error}
    if found.model_error:
        columns["written model"] = found.model_error
    columns |= {f"held out: {source}": dict(error) for source, error in heldout.items()}
    table = pd.DataFrame(columns).map(lambda error: f"{error:.3g}" if error == error else "-")
    return table.rename_axis("joint").reset_index()


def _parameters(found: Identified, prior: Robot | None) -> pd.DataFrame:
    values, units, std = found.robot.parameters, found.robot.units, found.solution.std
    before = prior.parameters if prior else {}
    bound = set(found.at_bound)
    rows = [
        {
            "parameter": name,
            "unit": units[name],
            "written": f"{values[name]:.5g}" + (" (at its bound)" if name in bound else ""),
            "estimate": f"{found.solution.p[i]:.5g}" if found.support[name] == "alone" else "",
            "± 95 %": _half(std[i]) if found.support[name] == "alone" else "",
            "prior": f"{before[name]:.5g}" if name in before else "",
            "determined": _DETERMINED[found.support[name]],
        }
        for i, name in enumerate(found.reduced.columns)
    ]
    table = pd.DataFrame(rows)
    return table if prior else table.drop(columns="prior")


def _base(found: Identified) -> pd.DataFrame:
    units = found.robot.units
    rows = [(b.expression, f"{b.value:.5g}", _half(b.std), units[b.terms[0][1]]) for b in found.base]
    return pd.DataFrame(rows, columns=["combination", "value", "± 95 %", "unit"])


def _half(std: float) -> str:
    return f"{CONFIDENCE * std:.2g}" if np.isfinite(std) and std > 0 else "not given"


def _alike(found: Identified) -> tuple[str, Sequence[Picture], pd.DataFrame | None]:
    pairs = correlations(found.solution, found.reduced.columns)
    if not pairs:
        return "Without intervals nothing is known of correlations.", (), None
    strong = sum(abs(r) > _NOTICED for r, *_ in pairs)
    text = "The most correlated pairs of parameters. " + (
        f"{strong} of them beyond {_NOTICED:g}: in these data the two do nearly the same, and one makes up "
        "for an error of the other; a motion that tells them apart would help (pyident excite)."
        if strong
        else f"None is beyond {_NOTICED:g}."
    )
    rows = [(one, other, f"{r:+.3f}") for r, one, other in pairs]
    return text, (), pd.DataFrame(rows, columns=["parameter", "and", "correlation"])


def _left(residuals: Sequence[JointResidual]) -> Section:
    figure = Figure(figsize=(9, 2.2 * len(residuals)), layout="constrained")
    for axes, joint in zip(
        np.atleast_1d(figure.subplots(len(residuals), sharex=True)), residuals, strict=True
    ):
        axes.loglog(joint.frequency[1:], joint.torque[1:], color="0.6", label="torque")
        axes.loglog(joint.frequency[1:], joint.residual[1:], color="C3", label="left by the written model")
        axes.set(title=joint.name, ylabel="per √Hz")
        axes.grid(alpha=0.3)
    figure.axes[0].legend()
    figure.axes[-1].set_xlabel("frequency [Hz]")
    rows = [(joint.name, f"{100 * joint.slow:.0f} %", _verdict(joint.slow)) for joint in residuals]
    return Section(
        "What is left",
        f"Of white noise {100 * SLOW:.0f} % of the power lies below {100 * SLOW:.0f} % of the band, of what "
        "encoder noise makes of a torque much less. More is slow, and slow is what a missing effect leaves: "
        "pyident diagnose tells it from what the method itself leaves, which this table does not.",
        [Picture(figure, "Spectra of the motor torques, and of what the written model leaves of them.")],
        pd.DataFrame(rows, columns=["joint", f"power below {100 * SLOW:.0f} % of the band", "reads as"]),
    )


def _verdict(slow: float) -> str:
    if slow < SLOW:
        return "fast: noise of encoders"
    return "as white noise" if slow < 2 * SLOW else "slow: more than noise, or friction at reversals"
