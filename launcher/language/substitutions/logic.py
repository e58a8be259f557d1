"""Boolean substitutions, equality, and the choice between two texts."""

from __future__ import annotations

import math
from collections.abc import Iterable

from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.language.type_utils import is_substitution, perform_typed_substitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext

_MODULE = "launch.substitutions.boolean_substitution"


def _truth(context: LaunchContext, value: list[Substitution]) -> bool:
    try:
        return bool(perform_typed_substitution(context, value, bool))
    except (TypeError, ValueError) as error:
        failure = SubstitutionFailure(error)
        # Imported only for an error.
        from launcher.language.diagnostics.truth_values import add_source

        add_source(failure, context, value, perform_substitutions(context, value))
        raise failure from error


def _text(truth: bool) -> str:
    return "true" if truth else "false"


@public(_MODULE)
class NotSubstitution(Substitution):
    """The opposite of a truth value."""

    value: list[Substitution] = read_only()

    def __init__(self, value: object) -> None:
        self.__value = normalize_to_list_of_substitutions(value)

    @property
    def _operands(self) -> list[list[Substitution]]:
        return [self.value]

    def describe(self) -> str:
        return f"NotSubstitution({self.value})"

    def perform(self, context: LaunchContext) -> str:
        """`true` or `false`; SubstitutionFailure if the value is neither."""
        return _text(not _truth(context, self.value))


class _TwoSided(Substitution):
    """Base of substitutions of two values."""

    left: list[Substitution] = read_only()
    right: list[Substitution] = read_only()

    def __init__(self, left: object, right: object) -> None:
        self.__left = normalize_to_list_of_substitutions(left)
        self.__right = normalize_to_list_of_substitutions(right)

    @property
    def _operands(self) -> list[list[Substitution]]:
        return [self.left, self.right]

    def describe(self) -> str:
        return f"{type(self).__name__}({self.left} {self.right})"


def _truths(context: LaunchContext, *values: list[Substitution]) -> list[bool]:
    """All values are performed; SubstitutionFailure if one is neither true nor false."""
    return [_truth(context, value) for value in values]


@public(_MODULE)
class AndSubstitution(_TwoSided):
    """Whether both values are true."""

    def perform(self, context: LaunchContext) -> str:
        return _text(all(_truths(context, self.left, self.right)))


@public(_MODULE)
class OrSubstitution(_TwoSided):
    """Whether one of the values is true."""

    def perform(self, context: LaunchContext) -> str:
        return _text(any(_truths(context, self.left, self.right)))


class _ManySided(Substitution):
    """Base of substitutions of any number of truth values."""

    args: list[list[Substitution]] = read_only()
    _operands: list[list[Substitution]] = read_only(of="args")

    def __init__(self, *args: object, container: Iterable[object] | None = None) -> None:
        every = (*args, *(container or ()))
        self.__args = [normalize_to_list_of_substitutions(arg) for arg in every]

    def describe(self) -> str:
        return f"{type(self).__name__}({' '.join(str(arg) for arg in self.args)})"


@public(_MODULE)
class AnySubstitution(_ManySided):
    """Whether at least one of the values is true."""

    def perform(self, context: LaunchContext) -> str:
        return _text(any(_truths(context, *self.args)))


@public(_MODULE)
class AllSubstitution(_ManySided):
    """Whether all of the values are true."""

    def perform(self, context: LaunchContext) -> str:
        return _text(all(_truths(context, *self.args)))


@public("launch.substitutions.equals_substitution")
class EqualsSubstitution(_TwoSided):
    """Whether two values are equal; compared as truth values or numbers if both are."""

    def __init__(self, left: object, right: object) -> None:
        super().__init__(_normalize_operand(left), _normalize_operand(right))

    def perform(self, context: LaunchContext) -> str:
        left = perform_substitutions(context, self.left)
        right = perform_substitutions(context, self.right)
        return _text(_equal(left, right))


def _normalize_operand(value: object) -> list[Substitution]:
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    if value is None:
        value = ""
    return normalize_to_list_of_substitutions(
        str(value).lower() if isinstance(value, bool) else str(value)
    )


def _equal(left: str, right: str) -> bool:
    truths = {"true": True, "1": True, "false": False, "0": False}
    if left.lower() in truths and right.lower() in truths:
        return truths[left.lower()] == truths[right.lower()]
    try:
        return math.isclose(float(left), float(right))
    except ValueError:
        return left == right


@public("launch.substitutions.not_equals_substitution")
class NotEqualsSubstitution(EqualsSubstitution):
    """Whether two values differ."""

    def perform(self, context: LaunchContext) -> str:
        return _text(super().perform(context) == "false")


@public("launch.substitutions.if_else_substitution")
class IfElseSubstitution(Substitution):
    """One of two texts, by a truth value; only the chosen one is performed."""

    condition: list[Substitution] = read_only(of="_condition")
    if_value: list[Substitution] = read_only(of="_if_value")
    else_value: list[Substitution] = read_only(of="_else_value")

    def __init__(self, condition: object, if_value: object = "", else_value: object = "") -> None:
        if if_value == else_value == "":
            raise RuntimeError("One of if_value and else_value must be specified")
        self._condition = normalize_to_list_of_substitutions(condition)
        self._if_value = normalize_to_list_of_substitutions(if_value)
        self._else_value = normalize_to_list_of_substitutions(else_value)

    def describe(self) -> str:
        parts = (self.condition, self.if_value, self.else_value)
        texts = [describe_substitutions(part) for part in parts]
        return f"IfElseSubstitution({', '.join(texts)})"

    def perform(self, context: LaunchContext) -> str:
        """The chosen text; SubstitutionFailure if the condition is not a truth value."""
        chosen = self.if_value if _truth(context, self.condition) else self.else_value
        return perform_substitutions(context, chosen)
