"""One column of a recording and what is guessed of it."""

from dataclasses import dataclass

import numpy as np

from pyident.inspection.words import Side, Signal

PLACE = "its place among the columns"  # and nothing else, where no other witness follows
ORDER = "the order of names without numbers"
RANK = "the order of the numbers in the names"
LETTERS = "the order of the letters in the names"
GUESSED = (PLACE, ORDER, RANK, LETTERS)  # of which joint a column is, where nothing else says so


@dataclass(frozen=True)
class Channel:
    """A column and the guess.

    values   as they are in the file, but unwrapped where `turn` has the units per turn;  rate [Hz]
    signal, joint (from 1, None: not known or of no joint), side, unit (ours, None: not known)
    sign, offset (in the unit), delay [s]   what turns it into ours
    sure     whether everything that the mapping says of it is witnessed; else `doubt` asks
    wanted   whether its name says that it was asked for, not measured
    why      the witnesses
    """

    column: str
    values: np.ndarray
    rate: float
    signal: Signal
    joint: int | None
    side: Side
    unit: str | None
    sign: int = 1
    offset: float = 0.0
    delay: float = 0.0
    clock: str | None = None
    turn: float | None = None
    sure: bool = False
    wanted: bool = False
    why: tuple[str, ...] = ()
    doubt: str = ""

    @property
    def low(self) -> float:
        return float(np.nanmin(self.values))

    @property
    def high(self) -> float:
        return float(np.nanmax(self.values))

    @property
    def guessed(self) -> list[str]:
        """The witnesses by which alone its joint is guessed."""
        return [why for why in GUESSED if why in self.why]

    @property
    def name(self) -> str | None:
        """Our name for it, None where it is no signal of a log."""
        if self.signal in ("time", "deformation"):
            return "time" if self.signal == "time" else self.column
        kinds = {
            "position": {"joint": "joint{}.e", "motor": "motor{}.q", "link": "joint{}.link"},
            "reference": {"joint": "joint{}.r", "motor": "joint{}.r", "link": "joint{}.r"},
            "torque": {"joint": "joint{}.tau", "motor": "motor{}.tau", "link": "joint{}.tau"},
            "feedforward": dict.fromkeys(("joint", "motor", "link"), "joint{}.tau_ff"),
            "current": {"joint": "joint{}.tau", "motor": "motor{}.current", "link": "joint{}.tau"},
            "voltage": dict.fromkeys(("joint", "motor", "link"), "joint{}.tau"),
            "switch": dict.fromkeys(("joint", "motor", "link"), "joint{}.on"),
        }
        if self.joint is None or self.signal not in kinds:
            return None
        return kinds[self.signal][self.side].format(self.joint)
