"""The page of a diagnosis: one file that tells an engineer what is missing, why, and what to do next."""

from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from flexmodels.atomic import replacing
from flexmodels.effects import CATALOGUE
from pyident.diagnosis.result import Diagnosis, Named
from pyident.report import wording
from pyident.report.diagnosis_content import (
    findings,
    found_twice,
    joints,
    left_for,
    limit_table,
    parameters,
    ranking,
    worst_place,
)
from pyident.report.diagnosis_figures import band_name, heat_map, row_name, waterfall
from pyident.report.interactive import library
from pyident.report.law_sheet import law_sheet
from pyident.report.next_steps import commands

_LABELS = {
    "missing_effect": "Missing effect",
    "cannot_tell": "More than one effect fits",
    "unexplained": "Unexplained",
    "nothing_detectable": "Nothing detectable",
}
_FAR = 1.3  # floors: what is left above it is worth another diagnosis


def write_diagnosis(diagnosis: Diagnosis, path: str | Path, model: str = "") -> Path:
    """Write the page and return its path. model: as the command line names it, else the robot's own name.

    The file needs no other: it opens from a disk without a network. Raises OSError.
    """
    path = Path(path)
    environment = Environment(
        loader=PackageLoader("pyident", "report/templates"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters |= {
        "number": wording.number, "times": wording.times, "percent": wording.percent, "unit": wording.unit,
        "share": wording.share, "file": lambda source: Path(source).name,
    }  # fmt: skip
    html = environment.get_template("diagnosis.html").render(_content(diagnosis, model or diagnosis.robot))
    with replacing(path) as file:
        file.write_text(html, encoding="utf-8")
    return path


def _content(d: Diagnosis, model: str) -> dict[str, object]:
    """What the template shows, by name."""
    names = _effects(d)
    rows = sorted(d.rows, key=lambda row: [r.joint for r in d.rows].index(row.joint))
    return {
        "d": d,
        "model": model,
        "label": _LABELS[d.verdict],
        "found": findings(d),
        "ranking": ranking(d),
        "parameters": parameters(d),
        "joints": joints(rows, d.localised),
        "worst": worst_place(rows),
        "rows": [(row_name(row), row) for row in rows],
        "bands": [band_name(band) for band in rows[0].bands] if rows else [],
        "limits": limit_table(d.limits),
        "unseen": [limit for limit in d.limits if limit.reason],
        "commands": commands(d, model),
        "twice": found_twice(d),
        "left_for": left_for(d),
        "far": d.remaining > _FAR,
        "heat_map": heat_map(rows) if rows else "",
        "waterfall": waterfall(d) if len(d.stages) > 1 else "",
        "sheets": [law_sheet(CATALOGUE[name]) for name in names if name in CATALOGUE],
        "known": [name for name in names if name in CATALOGUE],
        "plotly": library(),
    }


def _effects(d: Diagnosis) -> Sequence[str]:
    """Every effect that the page names, those of the findings first."""
    named: list[Named] = [member for finding in d.findings for member in finding.tie]
    return list(
        dict.fromkeys(
            [*(n.effect for n in named), *(n.effect for n in d.ranking), *(x.effect for x in d.limits)]
        )
    )
