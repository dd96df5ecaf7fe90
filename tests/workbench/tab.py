"""A tab of the workbench without a browser: the framework's own simulated user, parts by their test ids."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from pyident.workbench.bench import Bench
from pyident.workbench.view import View

pytest.importorskip("nicegui", reason="the workbench's extra is not installed")

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement
from nicegui.testing import User
from nicegui.testing.user_interaction import UserInteraction
from nicegui.testing.user_simulation import user_simulation

from pyident.workbench.page import Page


class Tab:
    """What a person sees and does."""

    def __init__(self, user: User, page: Page):
        self.page, self.notices = page, user.notify.messages
        assert user.client is not None
        self.client = user.client
        self._user = user

    def _listed(self) -> list[ui.element]:
        assert self._user.client is not None
        return [e for e in self._user.client.elements.values() if not e.is_deleted]

    def __contains__(self, testid: str) -> bool:
        return any(e.props.get("data-testid") == testid for e in self._listed())

    def __getitem__(self, testid: str) -> Any:
        (element,) = [e for e in self._listed() if e.props.get("data-testid") == testid]
        return element

    @property
    def words(self) -> str:
        """Every text on the page, a line each."""
        return "\n".join(str(e.text) for e in self._listed() if isinstance(e, TextElement))

    def inside(self, testid: str) -> str:
        """The texts within a part."""
        return "\n".join(str(e.text) for e in self[testid].descendants() if isinstance(e, TextElement))

    async def settle(self) -> None:
        """Until what was asked for is done and drawn."""
        while True:
            self.page.bench.collect()
            if not any(isinstance(job, Prompt) and not job.running for job in self.page.bench.jobs.values()):
                break
        self.page._look()
        await asyncio.sleep(0.02)

    async def click(self, testid: str) -> None:
        assert self[testid].enabled, f"{testid} is greyed out"
        UserInteraction(self._user, {self[testid]}, None).click()
        await self.settle()

    async def trigger(self, testid: str, event: str, args: dict[str, Any]) -> None:
        """An event of the browser, such as the end of a zoom."""
        UserInteraction(self._user, {self[testid]}, None).trigger(event, args)
        await self.settle()

    async def choose(self, testid: str, value: Any) -> None:
        """Set what a field or a choice holds."""
        assert self._user.client is not None
        with self._user.client:
            self[testid].value = value
        await self.settle()


def visit(bench: Bench, steps: Callable[[Tab], Awaitable[None]], view: View | None = None) -> None:
    """Open one tab of a workbench and do something in it."""
    pages: list[Page] = []

    def root() -> None:
        pages.append(Page(bench, view or View()))
        pages[-1].build()

    async def visited() -> None:
        async with user_simulation(root) as user:
            await user.open("/")
            await steps(Tab(user, pages[-1]))

    asyncio.run(visited())


class Prompt:
    """In place of a job in another process: the work is done before anybody can look."""

    running, progress = False, 1.0

    def __init__(self, title: str, work: Callable[..., Any], *arguments: Any):
        self.title, self.result, self.error = title, None, ""
        try:
            self.result, self.state = work(*arguments, progress=lambda _: None), "done"
        except ValueError as error:
            self.error, self.state = str(error), "failed"

    def cancel(self) -> None:
        raise AssertionError("nothing is under way")


class Endless(Prompt):
    """Work that never comes to its end."""

    running, progress = True, 0.25

    def __init__(self, title: str, work: Callable[..., Any], *arguments: Any):
        self.title, self.work, self.arguments, self.cancelled = title, work, arguments, False

    def cancel(self) -> None:
        self.cancelled = True
