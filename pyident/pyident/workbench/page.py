"""The page: places on the left, the verdict and the versions always in sight, the chosen place below."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from nicegui import ui

from pyident.workbench.bench import Bench
from pyident.workbench.channels import Channels
from pyident.workbench.linked import scripts
from pyident.workbench.places import data, model, next_step, versions, where, why
from pyident.workbench.project import ProjectError
from pyident.workbench.view import PLACES, View

if TYPE_CHECKING:
    from pyident.diagnosis.result import Diagnosis

_WORDS = {
    "data": ("1 Data", "Which logs take part, and whether they can be believed"),
    "model": ("2 Model", "What the robot is, and what the logs can tell of it"),
    "where": ("3 Where", "Where model and logs disagree"),
    "why": ("4 Why", "Which law would explain it"),
    "next": ("5 Next", "What to do with the model, and what to measure next"),
}
_SHOW = {"data": data.show, "model": model.show, "where": where.show, "why": why.show, "next": next_step.show}
_VERDICTS = {
    "nothing_detectable": ("positive", "nothing detectable"),
    "missing_effect": ("warning", "an effect is missing"),
    "cannot_tell": ("info", "these logs cannot tell"),
    "unexplained": ("negative", "unexplained"),
}
_PERIOD = 0.4  # s between looks at the shared state


def _verdict_of(diagnosis: "Diagnosis") -> tuple[str, str]:
    """Colour and words."""
    named = [law for finding in diagnosis.findings for law in finding.tie]
    if diagnosis.verdict == "missing_effect" and all(law.describes for law in named):
        return "warning", "the robot file is wrong"
    return _VERDICTS[diagnosis.verdict]


class Page:
    """One open tab: what it looks at, and how it draws itself anew."""

    def __init__(self, bench: Bench, view: View):
        self.bench, self.view, self.seen = bench, view, bench.revision
        self.channels: Channels | None = None  # of the file that is looked at
        self.pair: tuple[int, int] | None = None  # versions that are compared

    def build(self) -> None:
        """Lay the page out."""
        self._take_version()
        ui.add_head_html(scripts())
        ui.colors(
            primary="#2b6ca3", warning="#b5480d", positive="#1b6e2e", negative="#b00020", info="#1c6680"
        )
        with ui.header().classes("items-center gap-4 wrap").props('role="banner"'):
            ui.label("flexident").classes("text-lg font-bold").props('role="heading" aria-level="1"')
            ui.label(str(self.bench.project.folder)).classes("text-sm").props('data-testid="folder"')
            self._verdict()
        self.told = ui.label(self.bench.told).props(
            'data-testid="told" role="status" aria-label="the same as a command"'
        )
        self.told.classes("font-mono text-xs break-all min-h-4")
        with ui.row().classes("w-full no-wrap max-md:flex-wrap"):
            with ui.column().classes("w-44 max-md:w-full shrink-0 max-md:flex-row max-md:gap-0"):
                self._places()
            with ui.column().classes("grow min-w-0"):
                self._progress()
                self._versions()
                self._content()
        ui.timer(_PERIOD, self._look)

    def go(self, **changes: object) -> None:
        """Look at something else; the URL follows."""
        self.look(**changes)
        self._places.refresh()
        self._content.refresh()

    def look(self, **changes: object) -> None:
        """Remember what is looked at, in the URL too; nothing is drawn anew."""
        self.view = self.view.at(version=self.bench.project.current, **changes)
        with self.told:  # a change of another tab is seen from outside this page
            ui.navigate.history.replace(f"/?{self.view.query}")

    def tell(self, command: str) -> None:
        """Show the command that does what was clicked."""
        self.told.set_text(command)

    def choose(self, before: int, after: int) -> None:
        """Two versions to hold side by side."""
        self.pair = before, after
        self._versions.refresh()

    def act(self, action: Callable[[], None]) -> None:
        """Do what a button says; a failure becomes a sentence on the page."""
        try:
            action()
        except (ProjectError, OSError, ValueError) as error:
            ui.notify(str(error), type="negative", multi_line=True)
        self.tell(self.bench.told)
        self._look()

    def _take_version(self) -> None:
        """That of the URL, where there is such a one."""
        asked, project = self.view.version, self.bench.project
        if asked is not None and asked != project.current and 0 <= asked < len(project.versions):
            self.bench.use(asked)
            self.seen = self.bench.revision

    def _look(self) -> None:
        self.bench.collect()
        if self.bench.jobs:
            self._progress.refresh()
        if self.seen != self.bench.revision:
            self.seen = self.bench.revision
            if self.bench.project.current != self.view.version:
                self.look()
            for part in (self._progress, self._versions, self._verdict, self._places, self._content):
                part.refresh()

    @ui.refreshable_method
    def _verdict(self) -> None:
        diagnosis = self.bench.result("diagnose")
        colour, text = _verdict_of(diagnosis) if diagnosis else ("blue-grey-8", "no diagnosis yet")
        badge = ui.badge(text, color=colour).classes("text-sm p-2").props('data-testid="verdict"')
        if diagnosis:
            badge.tooltip(diagnosis.sentence)

    @ui.refreshable_method
    def _places(self) -> None:
        for place in PLACES:
            label, hint = _WORDS[place]
            locked = place not in ("data", "model") and not self.bench.sound
            button = ui.button(label, on_click=lambda p=place: self.go(place=p))
            button.classes("w-full max-md:w-auto whitespace-nowrap")
            button.props(
                f'data-testid="place-{place}" align=left no-caps padding="sm"'
                + (" flat" if place != self.view.place else "")
            )
            button.set_enabled(not locked)
            button.tooltip("opens when the checks have passed for exactly these inputs" if locked else hint)

    @ui.refreshable_method
    def _progress(self) -> None:
        if self.bench.message:
            ui.label(self.bench.message).classes("text-negative whitespace-pre-wrap").props(
                'data-testid="message" role="alert"'
            )
        for what, job in list(self.bench.jobs.items()):
            with ui.row().classes("items-center w-full"):
                ui.label(f"{job.title} …").props(f'data-testid="job-{what}"')
                ui.linear_progress(job.progress, show_value=False).classes("grow").props(
                    f'aria-label="{job.title}"'
                )
                ui.button("Cancel", on_click=partial(self.act, partial(self.bench.cancel, what))).props(
                    f'data-testid="cancel-{what}" flat dense no-caps'
                )

    @ui.refreshable_method
    def _versions(self) -> None:
        project = self.bench.project
        if not project.versions:
            return
        with (
            ui.row()
            .classes("items-center gap-1")
            .props('data-testid="versions" aria-label="versions of the model"')
        ):
            for i, version in enumerate(project.versions):
                if i:
                    ui.label("→")
                chip = ui.button(
                    version.what if i else version.model,
                    on_click=partial(self.act, partial(self.bench.use, i)),
                ).props(
                    f'data-testid="version-{i}" dense no-caps' + (" outline" if i != project.current else "")
                )
                if version.command:
                    chip.tooltip(version.command)
            if project.current:
                ui.button(
                    "Undo", on_click=partial(self.act, partial(self.bench.use, project.current - 1))
                ).props('data-testid="undo" flat dense no-caps')
        if len(project.versions) > 1 and self.bench.sound:
            versions.show(self)

    @ui.refreshable_method
    def _content(self) -> None:
        place = self.view.place
        if place not in ("data", "model") and not self.bench.sound:
            ui.label(
                "This place opens when the checks have passed for exactly these logs and this model."
            ).props('data-testid="locked"')
            return
        _SHOW[place](self)
