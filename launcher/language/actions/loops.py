"""ForLoop and ForEach: entities made by a function for each iteration (newer than Jazzy)."""

from __future__ import annotations

import functools
from collections.abc import Callable

from launcher.language.action import Action
from launcher.language.class_tools import is_iterable
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.actions.for_loop")
@parsed
class ForEach(Action):
    """Calls `function(**fields)` for each set of `name=value` fields, separated by semicolons."""

    SEPARATOR = ";"
    input_values: object = read_only("The field sets as one text.", of="_input_values")
    function: object = read_only(of="_function")

    def __init__(
        self, input_values: object, *, function: Callable[..., Any] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._input_values = normalize_to_list_of_substitutions(input_values)
        self._function = function

    @property
    def _function_called(self) -> Any:
        """The function whose result is visited, for messages."""
        return getattr(self._function, "__wrapped__", self._function)

    def describe(self) -> str:
        values = describe_substitutions(self._input_values)
        return f"ForEach(input_values={values}, function={self._function})"

    def execute(self, context: LaunchContext) -> list[Any] | None:
        """Yield what the function returns for each set; TypeError for what is no set."""
        text = perform_substitutions(context, self._input_values)
        parts = [part for part in text.split(self.SEPARATOR) if part.strip()]
        field_sets = [self._fields(part) for part in parts]
        if not field_sets:
            context._host.warn_quirk("no input values: will not iterate", self._origin)
        if self._function is None:
            return None
        wanted = [fields for fields in field_sets if fields is not None]
        return [entity for fields in wanted for entity in self._entities(fields)]

    def _fields(self, part: str) -> dict[str, Any] | None:
        from launcher.base import yaml_bounds

        try:
            fields: dict[str, Any] | None = yaml_bounds.load(part)
        except Exception as error:
            from launcher.language.diagnostics.bad_entries import explain_field_set

            explain_field_set(error, part, self._origin)
            raise
        if fields is None or (isinstance(fields, dict) and all(isinstance(k, str) for k in fields)):
            return fields
        # Imported only for an error.
        from launcher.language.diagnostics.bad_entries import no_field_set

        raise no_field_set(fields, part, self._origin)

    def _entities(self, fields: dict[str, Any]) -> Any:
        assert self._function is not None
        found = self._function(**fields) or []
        if is_iterable(found):
            return found
        # Imported only for an error.
        from launcher.language.diagnostics.bad_entries import not_a_list

        raise not_a_list(found, self)


@public("launch.actions.for_loop")
@parsed
class ForLoop(Action):
    """Calls `function(index)` for each index from 0 below `length`."""

    length: object = read_only(of="_length")
    function: object = read_only(of="_function")
    name: str | None = read_only("The name of the index.", of="_name")

    def __init__(
        self,
        length: object,
        *,
        function: Callable[[int], Any] | None = None,
        name: str | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._length = normalize_to_list_of_substitutions(
            str(length) if isinstance(length, int) else length
        )
        self._function = function
        self._name = name

    def describe(self) -> str:
        length = describe_substitutions(self._length)
        return f"ForLoop(length={length}, function={self._function})"

    def execute(self, context: LaunchContext) -> list[Any] | None:
        """Yield a ForEach of the indices."""
        if self._function is None:
            return None
        function = self._function
        text = perform_substitutions(context, self._length)
        try:
            count = int(text)
        except ValueError as error:
            from launcher.language.diagnostics.bad_entries import explain_length

            explain_length(error, text, self._origin)
            raise
        indices = ForEach.SEPARATOR.join([f"{{i: {index}}}" for index in range(count)])

        @functools.wraps(function)
        def call(i: int) -> Any:
            return function(i)

        return [ForEach(indices, function=call)]
