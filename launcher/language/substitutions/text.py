"""Texts joined by a delimiter."""

from __future__ import annotations

from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.substitutions.string_join_substitution")
class StringJoinSubstitution(Substitution):
    """Texts joined by a delimiter; each text may be made of several substitutions."""

    substitutions: list[list[Substitution]] = read_only()
    delimiter: list[Substitution] = read_only()

    def __init__(self, substitutions: Any, delimiter: object = "") -> None:
        self.__substitutions = [normalize_to_list_of_substitutions(sub) for sub in substitutions]
        self.__delimiter = normalize_to_list_of_substitutions(delimiter)

    def describe(self) -> str:
        parts = ", ".join(describe_substitutions(subs) for subs in self.substitutions)
        return f"StringJoin({parts})"

    def perform(self, context: LaunchContext) -> str:
        delimiter = perform_substitutions(context, self.delimiter)
        return delimiter.join(perform_substitutions(context, sub) for sub in self.substitutions)
