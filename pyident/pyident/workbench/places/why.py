"""Place 4: the verdict of the diagnosis, what each law takes of the chosen stretch, trying and adding."""

from pathlib import Path
from typing import Any

from nicegui import ui

from pyident.workbench import commands, figures
from pyident.workbench.places.tab import Tab
from pyident.workbench.places.where import chosen_trace

_LISTED = 12  # laws of a ranking


def show(page: Tab) -> None:
    """The verdict always first: a ranking is never to be mistaken for it."""
    bench = page.bench
    diagnosis = bench.result("diagnose")
    with ui.row().classes("items-center w-full"):
        ui.button("Diagnose", on_click=lambda: page.act(bench.diagnose)).props(
            'data-testid="diagnose" no-caps'
        ).set_enabled("diagnose" not in bench.jobs)
        if diagnosis is None:
            ui.label("No diagnosis of this model and these logs yet.").props('data-testid="no-diagnosis"')
        else:
            ui.label(diagnosis.sentence).classes("text-base").props('data-testid="sentence"')
    for i, finding in enumerate(diagnosis.findings if diagnosis else ()):
        _finding(page, i, finding)
    _outcome(page)
    compared, waves = bench.result("compare"), bench.result("ask")
    if compared is None or waves is None or not compared.comparison.traces:
        ui.label(_no_ranking(page, compared)).props('data-testid="no-ranking"')
        return
    try:
        stretch = _Stretch(page, compared, waves, diagnosis)
    except ValueError as error:  # a span from the URL in which there is nothing
        ui.label(str(error)).props('data-testid="no-ranking"')
        return
    stretch.show()
    for sentence in diagnosis.depends_on if diagnosis else ():
        ui.label(sentence).classes("text-sm")


class _Stretch:
    """The laws of one stretch of one equation, and the curve that one of them would leave."""

    def __init__(self, page: Tab, compared: Any, waves: Any, diagnosis: Any):
        from pyident.verbs.explain import explained

        self.page, self.diagnosis = page, diagnosis
        self.trace = chosen_trace(page, compared.comparison)
        span, band = page.view.span, self.trace.band
        self.asked = explained(compared, waves, self.trace.log, self.trace.coordinate, span, band)
        self.ranking = self.asked.ranking

    def show(self) -> None:
        """Draw it."""
        r = self.ranking
        where = f"{r.coordinate} of {Path(r.log).name}, {r.span[0]:.2f} to {r.span[1]:.2f} s"
        where += f", {r.band[0]:.3g} to {r.band[1]:.3g} Hz" if r.band else ""
        ui.label(f"What each law would take of {where}").classes("font-bold mt-2").props(
            'data-testid="stretch"'
        )
        words = "A ranking of one stretch is no verdict: what stands here may only imitate what is missing."
        ui.label(f"{words} {self.asked.own}").classes("text-sm")
        ui.label(self._command()).classes("font-mono text-xs").props('data-testid="explain-command"')
        if not r.shares:
            ui.label("No law of the catalogue acts on this equation.").props('data-testid="no-laws"')
            return
        with ui.row().classes("w-full no-wrap max-lg:flex-wrap"):
            with ui.column().classes("w-[30rem] max-lg:w-full shrink-0 gap-1"):
                self._rows()
            with ui.column().classes("grow min-w-0"):
                self.plot = ui.plotly(self._figure(r.shares[0], tried=False)).classes("w-full")
                self.plot.props('data-testid="waveform" role="figure" aria-label="what a law would take"')
                self.words = ui.label("").props('data-testid="tried"')
        self._say(r.shares[0])

    def _command(self) -> str:
        """The command line that ranks the same."""
        r = self.ranking
        return commands.explaining(self.page.bench.inputs, r.log, r.coordinate, r.span, r.band)

    def _rows(self) -> None:
        tie = self.ranking.tie
        with ui.card().classes("w-full p-2 gap-1").props('data-testid="tie"'):
            if len(tie) > 1:
                ui.label("These differ by less than the floor here:").classes("text-sm")
            for i, share in enumerate(tie, start=1):
                self._row(i, share)
            for share in tie[:2] if len(tie) > 1 else ():
                if share.law.experiment:
                    ui.label(f"{share.law.name}: {share.law.experiment}").classes("text-sm")
        others = [s for s in self.ranking.shares if not s.tied]
        for i, share in enumerate(others[: max(_LISTED - len(tie), 2)], start=len(tie) + 1):
            self._row(i, share)

    def _row(self, number: int, share: Any) -> None:
        why = self._imitates(share.law)
        with ui.row().classes("items-center w-full no-wrap gap-2") as row:
            row.props(f'data-testid="law-{number}"')
            if why:
                row.classes("opacity-60")
            ui.label(share.law.name).classes("grow min-w-0")
            ui.linear_progress(share.shown / 100, show_value=False).classes("w-20").props(
                f'aria-label="share of {share.law.name}"'
            )
            ui.label(f"{share.shown:.0f} %").classes("w-12 text-right")
            ui.button("Try", on_click=lambda: self.try_law(share)).props(
                f'data-testid="try-{number}" flat dense no-caps'
            )
            add_button(self.page, share.law, f"law-add-{number}")
        if why:
            ui.label(why).classes("text-xs").props(f'data-testid="imitates-{number}"')

    def try_law(self, share: Any) -> None:
        """Show what the residual would be with a law."""
        self.page.tell(self._command())
        self.plot.update_figure(self._figure(share, tried=True))
        self._say(share)

    def _say(self, share: Any) -> None:
        r, t = self.ranking, self.trace
        at = (t.time >= r.span[0]) & (t.time <= r.span[1]) & t.used
        before, after = (float((v[at] ** 2).mean() ** 0.5) for v in (t.residual, share.left))
        values = ", ".join(f"{n} {v:.4g} {share.law.units[n]}" for n, v in share.law.values.items())
        self.words.set_text(
            f"With {share.law.name} ({values}): rms {before:.3g} → {after:.3g} in this stretch"
        )

    def _figure(self, share: Any, tried: bool) -> dict[str, Any]:
        taken = self.trace.residual - share.left
        curves = [(taken, f"taken with {share.law.name}", figures.BLUE)]
        if tried:
            curves.append((share.left, "residual with it", figures.GREEN))
        return figures.stretch(self.trace, self.page.view.span, curves)

    def _imitates(self, law: Any) -> str:
        """The diagnosis' sentence on a law that only imitates what is missing."""
        sentences = self.diagnosis.depends_on if self.diagnosis else ()
        return next((s for s in sentences if s.startswith(f"{law.name} fits in part")), "")


def _no_ranking(page: Tab, compared: Any) -> str:
    """Why no law can be asked what it would take."""
    if "compare" in page.bench.jobs or "ask" in page.bench.jobs:
        return "Every law is being asked what it would take."
    if compared is not None and not compared.comparison.traces:
        return "The model cannot be simulated, so that no stretch stands out; identify it in place 2."
    return "Compare model and logs in place 3; then every law can be asked what it would take."


def _finding(page: Tab, number: int, finding: Any) -> None:
    from pyident.diagnosis.verdict import taken_by
    from pyident.verbs.judged import said_value

    with ui.card().classes("w-full").props(f'data-testid="finding-{number + 1}"'):
        if finding.alike:
            ui.label("These describe the same robot; correct one of them:").classes("text-sm")
        elif not finding.settled:
            ui.label("These logs cannot tell these apart:").classes("text-sm")
        for i, named in enumerate(finding.tie):
            values = ", ".join(said_value(named, n) for n in named.values)
            with ui.row().classes("items-center"):
                of = " of the robot file" if named.describes else ""
                ui.label(f"{named.effect} at {named.joint}{of}").classes("font-bold")
                ui.label(values).classes("text-sm")
                add_button(page, named, f"add-{number + 1}-{i + 1}", "Correct it" if of else "Add")
        ui.label(f"takes {taken_by(finding)}")
        if finding.experiment:
            ui.label(f"To separate: {finding.experiment}").classes("text-sm")


def add_button(page: Tab, named: Any, name: str, words: str = "Add") -> None:
    """Adds a law to the model: fits it and judges it on unseen data."""
    joint = int(named.joint.removeprefix("joint"))
    button = ui.button(words, on_click=lambda: page.act(lambda: page.bench.add(named.effect, joint)))
    button.props(f'data-testid="{name}" dense no-caps').set_enabled("add" not in page.bench.jobs)


def _outcome(page: Tab) -> None:
    """What came of the law that was added last."""
    last = page.bench.last_added
    if last is None:
        return
    ui.label("What was added last: error on held-out and on fitted logs").classes("font-bold mt-2")
    words = "accepted" if last.accepted else f"refused: {last.reason}"
    ui.label(words).classes("text-positive" if last.accepted else "text-negative").props(
        'data-testid="outcome"'
    )
    ui.plotly(figures.waterfall(last.waterfall)).classes("w-full").props(
        'data-testid="waterfall" role="figure" aria-label="errors before and after, over their floor"'
    )
    with ui.column().classes("gap-0"):
        for i, step in enumerate(last.waterfall, start=1):
            ui.label(
                f"{step.name}, {step.data}: "
                f"{step.before:.4g} → {step.after:.4g} {step.unit}, floor {step.floor:.4g}"
            ).props(f'data-testid="fall-{i}"').classes("text-sm")
