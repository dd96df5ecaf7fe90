"""A verdict, in a word and in a sentence."""

import re
from collections.abc import Hashable, Mapping, Sequence

from flexmodels.coordinate import joint_name, joint_number
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.result import Finding, Named, Place, VerdictName
from pyident.regression.descriptions import outside_file, place_name
from pyident.rules.rules import RULES

_UNTOLD = ", these logs cannot tell which"
_ALIKE = ", which describe the same robot: correct one of them"
_MANY = 4  # findings, up to which the sentence tells what each takes
_HARDLY = 10.0  # per cent of an excess: less than any effect takes that is named for its share


def verdict_of(findings: Sequence[Finding], stands_out: bool) -> VerdictName:
    """stands_out: whether the residual exceeds the replicas' by far."""
    if findings:
        return "missing_effect" if all(f.settled for f in findings) else "cannot_tell"
    return "unexplained" if stands_out else "nothing_detectable"


def asked_for(robot: Robot, tie: Sequence[Candidate]) -> str:
    """What the rivals' own laws ask for, empty without a rival."""
    if len(tie) < 2:
        return ""
    laws = [(c, law_of(robot, c)) for c in tie[:2]]
    each = (f"for {law.name} at joint {c.joint}: {law.experiment}" for c, law in laws)
    return "; ".join(dict.fromkeys(each))  # a payload may be of one log or another


def place_of(robot: Robot, candidate: Candidate) -> tuple[str, str]:
    """Joint and side of the law that was found; an error of the robot file shows at the joint's last side."""
    acts = {str(q) for q in law_of(robot, candidate).forces}
    there = [c for c in robot.q if c.joint == candidate.joint]
    sides = [c.side for c in there if c.symbol in acts]
    return joint_name(candidate.joint), sides[0] if sides else there[-1].side


def sentence_of(
    verdict: VerdictName,
    findings: Sequence[Finding],
    places: Sequence[Place],
    place: tuple[str, str],
    doubted: Sequence[str] = (),
    shaken: Sequence[str] = (),
    noisy: Mapping[str, float] | None = None,
) -> str:
    """What a diagnosis says.

    places    every side of every joint, in the robot's order;  place: where it fails most
    doubted   joints at which slow noise may be all that exceeds the floor, or not
    shaken    joints whose noise comes in bursts;  noisy: joint -> high floor, per cent of its torque
    """
    if verdict == "nothing_detectable":
        noise = _of_noise(noisy or {}, {p.joint for p in places if p.state != "unobserved"})
        if noise is None:
            return (
                "These logs could show nothing: what counts as noise is more than the torque, at every joint."
            )
        unless = f"; at {', '.join(doubted)} they do not tell it from slow noise" if doubted else ""
        bursts = f"; what is left at {', '.join(shaken)} comes in bursts" if shaken else ""
        return f"Nothing is missing that these logs could show{unless}{bursts}{noise}."
    open_places = [p for p in places if p.state == "unexplained"]
    if verdict == "unexplained":
        listed = [f"{p.joint}, {p.balance} side" for p in open_places] or [f"{place[0]}, {place[1]} side"]
        where = " and ".join(listed) if len(listed) < 3 else "; ".join(listed)
        return f"Something is missing at {where}, but no effect of the catalogue explains it."
    brief = len(findings) > _MANY
    each = _by_law(findings) if brief else [f"{_names(f)} ({taken_by(f)}){_of_tie(f)}" for f in findings]
    plain = len(each) < 3 and not each[0].endswith((_UNTOLD, _ALIKE))
    names = (" and " if plain else "; ").join(each)
    left, little = ([p for p in open_places if _hardly_any(p) == few] for few in (False, True))
    rest = f" Unexplained remains {_each(left, brief)}." if left else ""
    rest += f" Of what it lacks hardly anything remains at {_each(little, brief)}." if little else ""
    wrong = {n.describes for f in findings for n in f.tie}
    begin = "Missing or wrong" if len(wrong) > 1 else "Wrong" if True in wrong else "Missing"
    return f"{begin}: {names}.{rest}"


def _of_noise(noisy: Mapping[str, float], joints: set[str]) -> str | None:
    """How much of the torques counts as noise, in words; None: at all joints all of it."""
    drowned = [joint for joint, percent in noisy.items() if percent >= 100.0]
    if drowned and set(drowned) == joints:
        return None
    if drowned:
        return f"; at {', '.join(drowned)} noise is more than the torque, and hides all"
    if not noisy:
        return ""
    worst = max(noisy, key=lambda joint: noisy[joint])
    return f"; {noisy[worst]:.0f} % of the torque of {worst} counts as noise"


def _by_law(findings: Sequence[Finding]) -> list[str]:
    """Many findings in few words: laws with all joints at which they are named, alone first."""
    groups = of_the_same_laws(findings)
    alone = [g for g in groups if len(g[0].tie) == 1 and not g[0].tie[0].describes]
    said = [f"{g[0].tie[0].effect} at {_at(g)}" for g in alone]
    for g in groups:
        if g in alone:
            continue
        laws = " or ".join(n.effect for n in g[0].tie)
        said.append(f"{_names(g[0]) if len(g) == 1 else f'{laws} at {_at(g)}'}{_of_tie(g[0])}")
    return said


def of_the_same_laws(findings: Sequence[Finding]) -> list[list[Finding]]:
    """Findings in groups, each of the same laws, or rivals, at joints of its own."""
    groups: dict[Hashable, list[Finding]] = {}
    for number, f in enumerate(findings):
        one_joint = len({n.joint for n in f.tie}) == 1 and not any(n.describes for n in f.tie)
        key = frozenset((n.effect, n.log) for n in f.tie) if one_joint else number
        groups.setdefault(key, []).append(f)
    return list(groups.values())


def separating(findings: Sequence[Finding]) -> list[str]:
    """What separates the ties: of the same rivals at several joints once."""
    out = []
    for group in of_the_same_laws(findings):
        asked = [f for f in group if f.experiment]
        if len(asked) > 1 and all(f.experiment.startswith("for ") for f in asked):
            laws = re.sub(r" at joint \d+:", ":", asked[0].experiment)
            out.append(f"at {_at(asked)}, {laws}")
        else:
            out += [f.experiment for f in asked]
    return out


def _at(findings: Sequence[Finding]) -> str:
    return _listed(sorted({joint_number(f.tie[0].joint) for f in findings}))


def _listed(joints: Sequence[int]) -> str:
    *first, last = (str(k) for k in joints)
    return f"joints {', '.join(first)} and {last}" if first else f"joint{last}"


def _names(finding: Finding) -> str:
    return " or ".join(_said(n) for n in finding.tie)


def _of_tie(finding: Finding) -> str:
    if len(finding.tie) == 1:
        return ""
    return _ALIKE if finding.alike else _UNTOLD


def _each(places: Sequence[Place], brief: bool) -> str:
    return ", ".join(f"{p.joint}, {p.balance} side{'' if brief else f' ({_floors(p)})'}" for p in places)


def _hardly_any(place: Place) -> bool:
    """Whether the findings took so much of what exceeded the floor that the rest may be of their form."""
    before, after = (ratio**2 - 1 for ratio in place.over_floor)
    return after < (1 - RULES.search.whole) * before


def _floors(place: Place) -> str:
    """What is left there, in the band where it stands out most."""
    if place.band is None:
        return f"{place.over_floor[1]:.2g} floors"
    low, high, ratio = place.band
    return f"{ratio:.2g} floors from {low:g} to {high:.3g} Hz"


def _said(named: Named) -> str:
    """A law at its joint, or what the robot file says wrongly."""
    if not named.describes:
        return named.where
    ((name, value),) = named.values.items()
    outside = outside_file(named.effect)
    if outside is not None:
        return outside.said(named.joint, value, named.units[name])
    place = place_name(joint_number(named.joint), named.effect)
    return f"{place} of the robot file by about {value:.2g} {named.units[name]}"


def taken_by(finding: Finding) -> str:
    """What it takes of what exceeds the floor, in words."""
    if finding.share_percent < _HARDLY:
        return "hardly more than the floor, but held-out data show it alike"
    share = f"{said_share(finding.share_percent)} of what exceeds the floor there"
    unseen, std = finding.heldout_gain_percent, finding.heldout_std_percent
    if unseen is None:
        return share
    if std is not None and unseen < RULES.search.again * std:
        return f"{share}, {said_share(unseen, std)} on held-out data, which may be chance"
    return f"{share}, {said_share(unseen)} on held-out data"


def said_share(percentage: float, std: float | None = None) -> str:
    """Of an excess, of which nothing takes more than all; std: its standard deviation [%], if it is said."""
    chance = "" if std is None else f" ± {std:.0f}"
    return f"{min(percentage, 100.0):.0f}{chance} %"
