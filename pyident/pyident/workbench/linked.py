"""Figures and the arm on one page: scripts of the browser that connect them without a word to the server."""

import json
from importlib.resources import files

from nicegui import ui

from pyident.verbs.figures.pictures import MovingArm, arm_script

# The framework's bar of requests has no name for screen readers; jobs have named ones of their own.
_STYLE = "<style>.q-loading-bar { display: none }</style>"


def scripts() -> str:
    """What a page's head holds."""
    linked = files("pyident.workbench").joinpath("linked.js").read_text(encoding="utf-8")
    return f"{_STYLE}<script>{arm_script()}\n{linked}</script>"


def show_arm(arm: MovingArm, height: int = 340) -> ui.element:
    """The arm in 3D; its keyframes go to the browser once."""
    place = ui.element("div").classes("w-full").props('data-testid="scene"')
    content = json.dumps(arm.content(height), separators=(",", ":"))
    _when([place], f"(place) => flexidentArm(place, {content})")
    return place


def share_cursor(plot: ui.element, log: str) -> None:
    """One moment in the arm and in a figure over time."""
    _when([plot], f"(plot) => flexidentCursor(plot, {json.dumps(log)})")


def share_brush(states: ui.element, traces: ui.element, words: ui.element) -> None:
    """Samples marked in one panel are marked in all."""
    _when([states, traces, words], "(...all) => flexidentBrush(...all)")


def name_upload(upload: ui.element, name: str) -> None:
    """A name for screen readers on Quasar's button, which has none and holds the file input."""
    names = json.dumps({"role": "link", "aria-label": name})
    _when(
        [upload],
        f"""(place) => {{
            const button = place.querySelector("a.q-btn");
            for (const [key, value] of Object.entries({names})) button?.setAttribute(key, value);
            place.querySelector("input[type=file]")?.setAttribute("aria-label", {json.dumps(name)});
        }}""",
    )


def _when(elements: list[ui.element], call: str) -> None:
    ui.run_javascript(f"flexidentWhen({[e.id for e in elements]}, {call})")
