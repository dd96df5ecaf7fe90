"""The command lines that a diagnosis leads to."""

from collections.abc import Sequence
from pathlib import Path
from shlex import join

from flexmodels.coordinate import joint_number
from pyident.diagnosis.result import Diagnosis, Named
from pyident.regression.descriptions import describes, place_name, stated


def commands(d: Diagnosis, model: str) -> list[tuple[str, list[str]]]:
    """What to run, each with its heading; empty where there is nothing to add."""
    if d.verdict == "missing_effect":
        chosen = [f.tie[0] for f in d.findings]
        return [("Add it and fit again, then diagnose the new model", _chain(d, model, chosen))]
    if d.verdict == "cannot_tell":
        tie = next(f.tie for f in d.findings if not f.settled)
        rest = [f.tie[0] for f in d.findings if f.tie is not tie]
        return [(f"If it is {n.effect} at {n.joint}", _chain(d, model, [n, *rest])) for n in tie]
    return []


def _chain(d: Diagnosis, model: str, chosen: Sequence[Named]) -> list[str]:
    """Each effect added to the model of the line before, once per joint, and a new diagnosis.

    A torque's gain, which no robot file states, is left out: it is corrected in the mapping of the logs. Of a
    log whose last part was held out every command holds it out by itself.
    """
    lines, name, last = [], Path(model).stem, model
    held = [word for log in d.heldout if log not in d.logs for word in ("--holdout", log)]
    for n in {(n.effect, n.joint): n for n in chosen if stated(n.effect)}.values():
        name = f"{name}_{'geometry' if n.describes else n.effect}"
        new = f"{name}.toml"
        logs = [n.log] if n.log else [*d.logs, *held]
        lines.append(
            join(["pyident", "add", last, *words_of(n.effect, joint_number(n.joint)), *logs, "-o", new])
        )
        last = new
    lines.append(join(["pyident", "diagnose", last, *d.logs, *held]))
    return lines


def words_of(effect: str, joint: int) -> list[str]:
    """What `add` is given for a law at a joint (from 1), or for an error of the description."""
    if describes(effect):
        return ["geometry", place_name(joint, effect)]
    return [effect, "--joint", str(joint)]
