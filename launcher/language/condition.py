"""Condition: the question whether an action is carried out."""

from __future__ import annotations

from collections.abc import Callable

from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext


@public("launch.condition")
class Condition:
    """Answers with the predicate that it was given; without one the answer is no."""

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def describe(self) -> str:
        """A text for people."""
        return self.__repr__()

    def evaluate(self, context: LaunchContext) -> bool:
        """Whether the action is carried out in this context."""
        if self._predicate is None:
            return False
        return self._predicate(context)
