"""A verdict, in a word and in a sentence."""

from collections.abc import Sequence

from flexmodels.coordinate import joint_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.result import Finding, VerdictName

_NEARLY_ALL = 0.9  # of the excess


def verdict_of(findings: Sequence[Finding], stands_out: bool) -> VerdictName:
    """stands_out: whether the residual exceeds the replicas' by far."""
    if findings:
        return "missing_effect" if all(len(f.tie) == 1 for f in findings) else "cannot_tell"
    return "unexplained" if stands_out else "nothing_detectable"


def asked_for(robot: Robot, tie: Sequence[Candidate]) -> str:
    """What the rivals' own laws ask for, empty without a rival."""
    if len(tie) < 2:
        return ""
    laws = [(c, law_of(robot, c)) for c in tie[:2]]
    return "; ".join(f"for {law.name} at joint {c.joint}: {law.experiment}" for c, law in laws)


def place_of(robot: Robot, candidate: Candidate) -> tuple[str, str]:
    """Joint and side of the law that was found."""
    acts = {str(q) for q in law_of(robot, candidate).forces}
    sides = [c.side for c in robot.q if c.joint == candidate.joint and c.symbol in acts]
    return joint_name(candidate.joint), sides[0] if sides else "link"


def sentence_of(
    verdict: VerdictName, findings: Sequence[Finding], explained: float, place: tuple[str, str]
) -> str:
    if verdict == "nothing_detectable":
        return "Nothing is missing that these logs could show."
    if verdict == "unexplained":
        where = f"{place[0]}, {place[1]} side"
        return f"Something is missing at {where}, but no effect of the catalogue explains it."
    names = " and ".join(" or ".join(f"{n.effect} at {n.joint}" for n in f.tie) for f in findings)
    share = f"{100 * min(explained, 1.0):.0f} % of what exceeds the floor"
    rest = "" if explained >= _NEARLY_ALL else "; the rest is unexplained"
    if verdict == "cannot_tell":
        return f"Missing: {names}; these logs cannot tell which. It explains {share}{rest}."
    return f"Missing: {names}. Together with the model's own parameters it explains {share}{rest}."
