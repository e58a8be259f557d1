"""Watcher: what somebody who looks on at a run is told. For type checkers alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from launcher.language.diagnostics.origin import Origin


class Watcher(Protocol):
    """Somebody who wants to see the visits, for a picture of the launch file."""

    def visiting(self, entity: Any, depth: int) -> None:
        """The visit of an entity begins, `depth` levels below an event (from 1)."""

    def skipped(self, action: Any) -> None:
        """The condition of the action that is being visited said no."""

    def configured(self, name: str, value: Any, origin: Origin | None) -> None:
        """A launch configuration got a value; origin None: from the command line."""
