"""Substitution: a text that is known only when it is asked for."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.language import frontend_registry
from launcher.language.naming import public
from launcher.language.origin import Origin, caller_origin

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.substitution")
class Substitution:
    """Base of every substitution; subclasses override `perform` and may override `describe`."""

    _origin: Origin | None

    def __new__(cls, *args: Any, **kwargs: Any) -> Any:
        """Remember the place of creation."""
        substitution = super().__new__(cls)
        substitution._origin = caller_origin()
        return substitution

    def __init__(self) -> None:
        """Nothing to set; subclasses call it."""

    @classmethod
    def parse(cls, data: Sequence[Any]) -> Any:
        """(class, keyword arguments) for the words of `$(name word ...)` in XML and YAML."""
        return frontend_registry.parse_with("Substitution", cls, data)

    def describe(self) -> str:
        """A text for people."""
        return self.__repr__()

    def perform(self, context: LaunchContext) -> str:
        """The text in this context."""
        return ""


@public("launch.substitutions.substitution_failure")
class SubstitutionFailure(Exception):
    """A substitution could not be performed."""
