"""Core: what decides in a run that the supervisor carries out. For type checkers alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from launcher.model.events import Effect, Event


class Core(Protocol):
    """What drives the run: `launcher.interpreter.Interpreter`, or a test's own."""

    def start(self) -> Sequence[Effect]:
        """The effects of the launch file's static part."""

    def handle(self, event: Event) -> Sequence[Effect]:
        """The effects of what happened."""

    def watches_output(self, process_id: int) -> bool:
        """Whether ProcessOutput is wanted for this process."""

    def plan(self) -> Mapping[str, Any]:
        """What was asked for so far, ready for `json.dumps`."""

    def plan_lines(self) -> Sequence[str]:
        """The same for people, line by line."""
