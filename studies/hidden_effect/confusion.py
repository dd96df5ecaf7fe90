"""What was said about what: a table and its picture."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from .scoring import NAMING, Scored

OTHERS = {"null": "nothing hidden", "outside": "outside the catalogue", "unobservable": "not observable"}
NOTHING, UNEXPLAINED, ELSEWHERE, UNSURE = "nothing", "unexplained", "elsewhere", "cannot tell"
_WANTED = {
    "null": {NOTHING},
    "outside": {UNEXPLAINED},
    "unobservable": {NOTHING, UNSURE},
}


def confusion(cases: Sequence[Scored]) -> pd.DataFrame:
    """Counts: true effect × first name; pairs, which have two truths, are left out.

    The right effect at a wrong joint counts as `elsewhere`.
    """
    shown = [c for c in cases if c.kind in ("single", *OTHERS)]
    pairs = [(_true(c), _said(c)) for c in shown]
    effects = sorted({c.truth[0][0] for c in shown if c.kind == "single"})
    rows = [*effects, *(name for kind, name in OTHERS.items() if any(c.kind == kind for c in shown))]
    said = {s for _, s in pairs} | set(effects)
    special = [NOTHING, UNEXPLAINED, ELSEWHERE, UNSURE]
    columns = [*effects, *sorted(said - set(effects) - set(special)), *special]
    counts = pd.DataFrame(0, index=pd.Index(rows, name="true"), columns=columns)
    for true, name in pairs:
        counts.loc[true, name] = int(counts.at[true, name]) + 1
    return counts


def _true(case: Scored) -> str:
    return case.truth[0][0] if case.kind == "single" else OTHERS[case.kind]


def _said(case: Scored) -> str:
    if case.verdict not in NAMING:
        return NOTHING if case.verdict == "nothing_detectable" else case.verdict
    if case.kind == "unobservable" and case.verdict == "cannot_tell":
        return UNSURE
    effect, joint = case.first_tie[0]
    if case.kind == "single" and effect == case.truth[0][0] and joint != case.truth[0][1]:
        return ELSEWHERE
    return effect


def figure(counts: pd.DataFrame) -> Figure:
    """Green: as it should be; red: not."""
    fig = Figure(figsize=(3.2 + 0.36 * counts.shape[1], 2.2 + 0.32 * counts.shape[0]), layout="constrained")
    ax = fig.subplots()
    right = np.array([[_right(str(r), str(c)) for c in counts.columns] for r in counts.index])
    values = counts.to_numpy()
    kind = np.where(values == 0, 0, np.where(right, 1, 2))
    ax.imshow(kind, cmap=ListedColormap(["white", "#a8d5a2", "#f0a8a0"]), vmin=0, vmax=2, aspect="auto")
    for i, j in zip(*np.nonzero(values), strict=True):
        ax.text(j, i, str(values[i, j]), ha="center", va="center", fontsize=9)
    labels = [str(c).replace("_", " ") for c in counts.columns]
    ax.set_xticks(range(len(labels)), labels, rotation=60, ha="right", rotation_mode="anchor", fontsize=8)
    ax.set_yticks(range(len(counts)), [str(r).replace("_", " ") for r in counts.index], fontsize=8)
    ax.set_xticks(np.arange(-0.5, values.shape[1]), minor=True)
    ax.set_yticks(np.arange(-0.5, values.shape[0]), minor=True)
    ax.grid(which="minor", color="0.85", lw=0.6)
    ax.tick_params(which="both", length=0)
    ax.set_xlabel("first name of the diagnosis")
    ax.set_ylabel("what was hidden")
    return fig


def _right(true: str, said: str) -> bool:
    kinds = {name: kind for kind, name in OTHERS.items()}
    return said in _WANTED[kinds[true]] if true in kinds else said == true
