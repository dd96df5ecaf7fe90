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
    log whose last part was held out every command holds it out by itself. What one log carries is found
    between it and those without; of a load that is taken up within a log no command can speak.
    """
    loaded = {n.log for n in chosen if n.log}
    logs = [log for log in d.logs if not any(f"{n} ".startswith(f"{log} ") for n in loaded)] or list(d.logs)
    lines, name, last = [], Path(model).stem, model
    held = [word for log in d.heldout if log not in d.logs for word in ("--holdout", log)]
    everywhere = [n for n in chosen if stated(n.effect) and not n.log]
    for n in {(n.effect, n.joint): n for n in everywhere}.values():
        name = f"{name}_{'geometry' if n.describes else n.effect}"
        new = f"{name}.toml"
        words = words_of(n.effect, joint_number(n.joint))
        lines.append(join(["pyident", "add", last, *words, *logs, *held, "-o", new]))
        last = new
    alone = [log for log in d.logs if log in loaded and log not in logs]
    if alone:
        empty = f"{name}_empty.toml"
        lines.append(join(["pyident", "identify", last, *logs, "-o", empty]))
        lines += [
            join(["pyident", "payload", empty, logs[0], log, "-o", f"{name}_{Path(log).stem}.toml"])
            for log in alone
        ]
    lines.append(join(["pyident", "diagnose", last, *logs, *held]))
    return lines


def words_of(effect: str, joint: int) -> list[str]:
    """What `add` is given for a law at a joint (from 1), or for an error of the description."""
    if describes(effect):
        return ["geometry", place_name(joint, effect)]
    return [effect, "--joint", str(joint)]
