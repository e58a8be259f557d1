"""Conditions of actions: on an expression or on a launch configuration."""

from __future__ import annotations

import warnings
from collections.abc import Callable

from launcher.language.diagnostics.origin import FileLine, caller_origin
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    describe_substitutions,
    normalize_to_list_of_substitutions,
    optional_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.substitution import Substitution


VALID_TRUE_EXPRESSIONS = ["true", "1"]
VALID_FALSE_EXPRESSIONS = ["false", "0"]


@public("launch.condition")
class Condition:
    """Evaluates a predicate; without one it is False."""

    _origin: FileLine | None

    def __new__(cls, *args: object, **kwargs: object) -> Any:
        """Remember the place of creation."""
        condition = super().__new__(cls)
        condition._origin = caller_origin()
        return condition

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def describe(self) -> str:
        return self.__repr__()

    def evaluate(self, context: LaunchContext) -> bool:
        """Whether the action is carried out in this context."""
        if self._predicate is not None:
            return self._predicate(context)
        cls = type(self)
        if cls is not Condition and cls.evaluate is Condition.evaluate:
            # Imported only for a warning.
            from launcher.language.diagnostics.base_classes import false_condition

            false_condition(self, context)
        return False


@public("launch.conditions.invalid_condition_expression_error")
class InvalidConditionExpressionError(Exception):
    """The text of a condition is neither true nor false."""


def evaluate_condition_expression(context: LaunchContext, expression: Any) -> bool:
    """True for `true` and `1`, False for `false` and `0`; ignores case and outer whitespace."""
    expanded = perform_substitutions(context, expression).strip().lower()
    if expanded in VALID_TRUE_EXPRESSIONS:
        return True
    if expanded in VALID_FALSE_EXPRESSIONS:
        return False
    valid = ", ".join(VALID_TRUE_EXPRESSIONS + VALID_FALSE_EXPRESSIONS)
    error = InvalidConditionExpressionError(
        f"invalid condition expression, expected one of [{valid}] but got '{expanded}', "
        f"expanded from '{describe_substitutions(expression)}'"
    )
    # Imported only for an error.
    from launcher.language.diagnostics.truth_values import add_source

    add_source(error, context, expression, expanded)
    raise error


class _ExpressionCondition(Condition):
    predicate_expression: list[Substitution] = read_only()

    def __init__(self, predicate_expression: object) -> None:
        self.__predicate_expression = normalize_to_list_of_substitutions(predicate_expression)
        super().__init__(predicate=self._predicate_func)

    def _predicate_func(self, context: LaunchContext) -> bool:
        try:
            return evaluate_condition_expression(context, self.__predicate_expression)
        except Exception as error:
            # Imported only for an error.
            from launcher.language.diagnostics.error_details import details

            details(error).place = details(error).place or self._origin
            raise

    def describe(self) -> str:
        return f"{type(self).__name__}({describe_substitutions(self.__predicate_expression)})"


@public("launch.conditions.if_condition")
class IfCondition(_ExpressionCondition):
    """True if the expression is true."""


@public("launch.conditions.unless_condition")
class UnlessCondition(_ExpressionCondition):
    """True if the expression is false."""

    def _predicate_func(self, context: LaunchContext) -> bool:
        return not super()._predicate_func(context)


@public("launch.conditions.launch_configuration_equals")
class LaunchConfigurationEquals(Condition):
    """True if a launch configuration has a value; with None, if it does not exist."""

    launch_configuration_name: str = read_only()
    expected_value: list[Substitution] | None = read_only()

    def __init__(self, launch_configuration_name: str, expected_value: object) -> None:
        warnings.warn(
            f"{type(self).__name__} is deprecated: use IfCondition with EqualsSubstitution or "
            "NotEqualsSubstitution, for example IfCondition(EqualsSubstitution("
            f'LaunchConfiguration("{launch_configuration_name}"), "value"))',
            UserWarning,
            stacklevel=2,
        )
        self.__launch_configuration_name = launch_configuration_name
        self.__expected_value = optional_substitutions(expected_value)
        super().__init__(predicate=self._predicate_func)

    def describe(self) -> str:
        expected = self.__expected_value
        value = None if expected is None else describe_substitutions(expected)
        return f"{type(self).__name__}({self.__launch_configuration_name!r}, {value})"

    def _predicate_func(self, context: LaunchContext) -> bool:
        name = self.__launch_configuration_name
        expected = self.__expected_value
        if expected is None:
            return name not in context.launch_configurations
        if name not in context.launch_configurations:
            return False
        return bool(context.launch_configurations[name] == perform_substitutions(context, expected))


@public("launch.conditions.launch_configuration_not_equals")
class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """The opposite of LaunchConfigurationEquals."""

    def _predicate_func(self, context: LaunchContext) -> bool:
        return not super()._predicate_func(context)
