"""Several recordings with the same columns, such as a motion repeated: one mapping for all of them."""

from dataclasses import replace

from flexmodels.robot import Robot
from pyident.inspection.channel import Channel
from pyident.inspection.proposal import Proposal


def whole(proposal: Proposal, robot: Robot | None) -> bool:
    """Whether the recording has the position of every joint: without a robot, of each that it names."""
    joints = len(robot.joints) if robot is not None else proposal.joints
    found = {c.joint for c in proposal.channels if c.signal == "position" and c.name}
    return joints > 0 and found >= set(range(1, joints + 1))


def of_one_kind(proposals: list[Proposal]) -> Proposal:
    """The first recording's proposal for all of them, and a question wherever another one contradicts it."""
    first, others = proposals[0], proposals[1:]
    if not others:
        return first
    files = tuple(file for proposal in proposals for file in proposal.files)
    same = f"the {len(files)} files have the same columns and share one mapping; {first.files[0]} is shown"
    doubts = [doubt for other in others for doubt in _contradictions(first, other)]
    return replace(
        first, files=files, notes=(same, *first.notes), questions=(*first.questions, *dict.fromkeys(doubts))
    )


def _contradictions(first: Proposal, other: Proposal) -> list[str]:
    """Where a channel that both are sure of differs."""
    twins = {c.column: c for c in other.channels}
    pairs = [(c, twins[c.column]) for c in first.channels if c.name is not None and c.column in twins]
    return [
        f"{c.column} looks like {_said(c)} in {first.files[0]} and like {_said(twin)} in {other.files[0]}: "
        "which is it?"
        for c, twin in pairs
        if c.sure and twin.sure and _said(c) != _said(twin)
    ]


def _said(channel: Channel) -> str:
    return f"{channel.name} in {channel.unit or 'SI'}{' with its sign turned' if channel.sign < 0 else ''}"
