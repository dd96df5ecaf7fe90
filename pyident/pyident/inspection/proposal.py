"""The proposed mapping of a recording: what is known, what is asked, and the file that says so."""

import json
from dataclasses import dataclass, replace
from typing import Any

from pyident.inspection.channel import Channel
from pyident.inspection.drives import drive_line
from pyident.inspection.physics import mapping_of
from pyident.logs.mapping import Mapping

_NONE = (
    "[signals]  # ? no column is mapped: write a table like this one for each",
    '# [signals."joint1.e"]',
    '# source = "COLUMN"',
    '# unit = "rad"',
)


@dataclass(frozen=True)
class Proposal:
    """channels: every column; rate [Hz] where no time is logged; questions: what only the user knows."""

    files: tuple[str, ...]
    channels: tuple[Channel, ...]
    rate: float | None
    header: bool
    joints: int
    notes: tuple[str, ...]
    questions: tuple[str, ...]

    @property
    def mapping(self) -> Mapping:
        """What the guesses come to."""
        return replace(mapping_of(list(self.channels), self.rate), header=self.header)

    def json(self) -> dict[str, Any]:
        return {
            "files": list(self.files),
            "channels": [
                {"column": c.column, "signal": c.name or c.signal, "joint": c.joint, "unit": c.unit,
                 "sign": c.sign, "offset": c.offset, "delay_s": c.delay, "rate_hz": _finite(c.rate),
                 "low": c.low, "high": c.high, "sure": bool(c.sure), "why": list(c.why), "question": c.doubt}
                for c in self.channels
            ],
            "notes": list(self.notes),
            "questions": list(self.questions),
        }  # fmt: skip

    def toml(self) -> str:
        """The mapping file, questions as comments before what they are about."""
        lines = [
            f"# Proposed for {', '.join(self.files)}; lines with a question mark are guesses: confirm them."
        ]
        lines += [f"# ? {question}" for question in self.questions]
        lines.append(f"joints = {max(self.joints, 1)}")
        if not self.header:
            lines.append("header = false")
        time = next((c for c in self.channels if c.signal == "time"), None)
        if time is not None:
            lines.append(f"time = {{ source = {_quoted(time.column)}, unit = {_quoted(time.unit or '1')} }}")
        else:
            lines.append(f"rate = {self.rate}" if self.rate else "# rate = NUMBER  # ? samples per second")
        told = [c for c in self.channels if c.name is not None and c.signal != "time"]
        for c in sorted(told, key=lambda c: (c.joint or 0, c.signal)):
            lines += ["", *self._signal(c)]
        if not told:
            lines += ["", *_NONE]
        return "\n".join(lines) + "\n"

    def _signal(self, c: Channel) -> list[str]:
        lines = [f"# ? {c.doubt}"] if c.doubt else []
        lines += [f"[signals.{_quoted(str(c.name))}]", f"source = {_quoted(c.column)}"]
        if c.unit:
            lines.append(f"unit = {_quoted(c.unit)}")
        if c.sign < 0:
            lines.append("sign = -1")
        if c.offset:
            lines.append(f"offset = {c.offset:.10g}")
        if c.delay:
            lines.append(f"delay = {c.delay:.6g}")
        if c.turn:
            lines.append("unwrap = true")
        if c.clock:
            lines.append(f"time = {_quoted(c.clock)}")
        if c.signal in ("current", "voltage") and not c.sure:
            lines.append(drive_line(c))
        return lines


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _finite(value: float) -> float | None:
    return value if value == value else None
