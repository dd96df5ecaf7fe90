"""What a place sees of the tab that it is drawn in."""

from collections.abc import Callable
from typing import Protocol

from pyident.workbench.bench import Bench
from pyident.workbench.channels import Channels
from pyident.workbench.view import View


class Tab(Protocol):
    """One open tab (`pyident.workbench.page.Page`).

    channels   of the file that is looked at
    pair       versions that are compared
    """

    bench: Bench
    view: View
    channels: Channels | None
    pair: tuple[int, int] | None

    def go(self, **changes: object) -> None:
        """Look at something else; the URL follows."""

    def look(self, **changes: object) -> None:
        """Remember what is looked at, in the URL too; nothing is drawn anew."""

    def tell(self, command: str) -> None:
        """Show the command that does what was clicked."""

    def choose(self, before: int, after: int) -> None:
        """Two versions to hold side by side."""

    def act(self, action: Callable[[], None]) -> None:
        """Do what a button says; a failure becomes a sentence on the page."""
