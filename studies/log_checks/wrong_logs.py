"""Kinds of grossly wrong logs: what was done to a sound frame, by name.

A kind returns None where a robot or a log has nothing that it could spoil.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

from flexmodels.robot import Robot

Kind = Callable[[Robot, pd.DataFrame], pd.DataFrame | None]
KINDS: dict[str, Kind] = {}


def kind(name: str) -> Callable[[Kind], Kind]:
    def register(function: Kind) -> Kind:
        KINDS[name] = function
        return function

    return register


def positions(robot: Robot) -> list[str]:
    return [f"joint{k}.e" for k, _ in robot.numbered]


def torques(robot: Robot) -> list[str]:
    return [f"joint{k}.tau" for k, _ in robot.numbered]


def busy(frame: pd.DataFrame, names: list[str]) -> str:
    """The channel that goes farthest."""
    return max(names, key=lambda name: np.ptp(frame[name].to_numpy()))


def scaled(frame: pd.DataFrame, names: list[str], factor: float) -> pd.DataFrame:
    return frame.assign(**{name: factor * frame[name] for name in names})


def _scale(name: str, of: Callable[[Robot], list[str]], factor: float, which: slice | None = None) -> None:
    def change(robot: Robot, frame: pd.DataFrame) -> pd.DataFrame | None:
        names = of(robot)
        if which is not None:
            names = names[which]
            if not names or len(of(robot)) == 1:
                return None
        return scaled(frame, names, factor)

    KINDS[name] = change


def hinges(robot: Robot) -> list[str]:
    return [f"joint{k}.e" for k, joint in robot.numbered if joint.kind == "revolute"]


def slides(robot: Robot) -> list[str]:
    return [f"joint{k}.e" for k, joint in robot.numbered if joint.kind == "prismatic"]


_scale("all torques negated", torques, -1)
_scale("torque 1 negated", torques, -1, slice(0, 1))
_scale("torque 2 negated", torques, -1, slice(1, 2))
_scale("last torque negated", torques, -1, slice(-1, None))
_scale("all positions negated", positions, -1)
_scale("position 1 negated", positions, -1, slice(0, 1))
_scale("position 2 negated", positions, -1, slice(1, 2))
_scale("torques in mN m", torques, 1e3)
_scale("torques in kN m", torques, 1e-3)
_scale("torques in N cm", torques, 1e2)
_scale("torques ten times too large", torques, 10)
_scale("torques of the motors, gear of 100", torques, 1e-2)
_scale("torque 1 in mN m", torques, 1e3, slice(0, 1))
_scale("torque 2 in mN m", torques, 1e3, slice(1, 2))
_scale("torque 2 in kN m", torques, 1e-3, slice(1, 2))
_scale("positions in millirad or mm", positions, 1e3)
_scale("positions of the motors, gear of 100", positions, 100)
_scale("positions too small by 1000", positions, 1e-3)


@kind("angles in degrees")
def _(robot, frame):
    return scaled(frame, hinges(robot), 180 / np.pi) if hinges(robot) else None


@kind("angle 2 in degrees")
def _(robot, frame):
    return scaled(frame, hinges(robot)[1:2], 180 / np.pi) if len(hinges(robot)) > 1 else None


@kind("angles converted to radians twice")
def _(robot, frame):
    return scaled(frame, hinges(robot), np.pi / 180) if hinges(robot) else None


@kind("one slide in mm")
def _(robot, frame):
    return scaled(frame, slides(robot)[:1], 1e3) if slides(robot) else None


@kind("torques in raw counts")
def _(robot, frame):
    largest = max(frame[name].abs().max() for name in torques(robot))
    counts = scaled(frame, torques(robot), 32767 / largest)
    return counts.assign(**{name: counts[name].round() for name in torques(robot)})


def _time(name: str, factor: float) -> None:
    KINDS[name] = lambda robot, frame: frame.assign(time=frame["time"] * factor)


_time("time in ms", 1e3)
_time("time in µs", 1e6)
_time("time in ns", 1e9)
_time("time in minutes", 1 / 60)
_time("time too fast by 1000", 1e-3)


@kind("time in samples")
def _(robot, frame):
    return frame.assign(time=np.arange(len(frame), dtype=float))


def _order(name: str, order: Callable[[list[int]], list[int]], *signals: str) -> None:
    def change(robot: Robot, frame: pd.DataFrame) -> pd.DataFrame | None:
        numbers = list(range(1, len(robot.joints) + 1))
        new = order(list(numbers))
        if len(numbers) < 2 or new == numbers:
            return None
        return frame.assign(
            **{
                f"joint{k}.{s}": frame[f"joint{j}.{s}"]
                for s in signals
                for k, j in zip(numbers, new, strict=True)
            }
        )

    KINDS[name] = change


def _swapped(i: int, j: int) -> Callable[[list[int]], list[int]]:
    def order(numbers: list[int]) -> list[int]:
        if max(i, j) >= len(numbers):
            return numbers
        numbers[i], numbers[j] = numbers[j], numbers[i]
        return numbers

    return order


_order("torques 1 and 2 exchanged", _swapped(0, 1), "tau")
_order("torques 2 and 3 exchanged", _swapped(1, 2), "tau")
_order("torques 1 and 3 exchanged", _swapped(0, 2), "tau")
_order("positions 1 and 2 exchanged", _swapped(0, 1), "e")
_order("positions 2 and 3 exchanged", _swapped(1, 2), "e")
_order("joints 1 and 2 exchanged", _swapped(0, 1), "e", "tau")
_order("joints in reverse order", lambda numbers: numbers[::-1], "e", "tau")
_order("torques in reverse order", lambda numbers: numbers[::-1], "tau")
_order("torques one joint late", lambda numbers: [numbers[-1], *numbers[:-1]], "tau")
_order("positions one joint early", lambda numbers: [*numbers[1:], numbers[0]], "e")


def _shift(name: str, seconds: float = 0.0, one: bool = False, samples: int = 0) -> None:
    def change(robot: Robot, frame: pd.DataFrame) -> pd.DataFrame | None:
        shift = samples or round(seconds / float(np.median(np.diff(frame["time"]))))
        names = [busy(frame, torques(robot))] if one else torques(robot)
        cut = frame.assign(**{n: np.roll(frame[n].to_numpy(), shift) for n in names})
        inside = slice(abs(shift), len(frame) - abs(shift))
        return cut.iloc[inside].reset_index(drop=True)

    KINDS[name] = change


_shift("torques 20 ms late", 0.02)
_shift("torques 50 ms late", 0.05)
_shift("torques 100 ms late", 0.1)
_shift("torques 20 ms early", -0.02)
_shift("one torque 40 ms late", 0.04, one=True)
_shift("torques 1 s late", 1.0)
_shift("torques one sample late", samples=1)
_shift("torques two samples late", samples=2)
_shift("torques one sample early", samples=-1)
