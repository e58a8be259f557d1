"""Errors in XML and YAML launch files, each with its place.

They are LaunchFileErrors, and subclasses of what ROS 2 raises (AttributeError, TypeError, ...),
which `parse` methods of third-party actions may catch.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from launcher.base.errors import LaunchFileError
from launcher.base.text import did_you_mean, suggest

_SHOWN = 120  # characters of a text of the launch file in a message


@dataclass(frozen=True, slots=True)
class SourcePlace:
    """A spot in a launch file; line and column count from 1."""

    path: str
    line: int
    column: int | None = None
    source_line: str | None = None

    @property
    def where(self) -> str:
        """`file:line`, as error messages begin."""
        return f"{self.path}:{self.line}"


class FrontendError(LaunchFileError):
    """An error in an XML or YAML launch file; `others` are further, independent ones.

    `ros_type` is the name of the exception that ROS 2 raises for it.
    """

    ros_type = "RuntimeError"

    def __init__(
        self,
        message: str,
        *,
        place: SourcePlace | None = None,
        hint: str | None = None,
        ros_type: str | None = None,
    ) -> None:
        super().__init__(message, hint=hint)
        self.others: tuple[LaunchFileError, ...] = ()
        if ros_type is not None:
            self.ros_type = ros_type
        locate(self, place)

    def render(self) -> str:
        """This error and the others, as text."""
        return "\n".join([super().render(), *(other.render() for other in self.others)])


class MissingAttributeError(FrontendError, AttributeError):
    """A required attribute is missing."""

    ros_type = "AttributeError"


class AttributeTypeError(FrontendError, TypeError):
    """A value has the wrong type."""

    ros_type = "TypeError"


class UnexpectedContentError(FrontendError, ValueError):
    """An unknown attribute or tag, or a value that is not allowed."""

    ros_type = "ValueError"


class StructureError(FrontendError, RuntimeError):
    """The tags or keys do not form a launch description."""


def of_others(
    problem: Exception, place: SourcePlace | None, what: str, ros_type: str
) -> LaunchFileError:
    """The error for an exception of code that may be of another package, and may raise anything."""
    from launcher.language.diagnostics.error_details import details
    from launcher.language.diagnostics.own_faults import own_fault

    mistake = own_fault(problem, None if place is None else place.where)
    return mistake or FrontendError(
        f"{what}: {problem}", place=place, hint=details(problem).hint, ros_type=ros_type
    )


def first_of(errors: Sequence[LaunchFileError]) -> LaunchFileError:
    """The first error, carrying the others and those that they carry."""
    first, *others = errors
    if isinstance(first, FrontendError):
        for other in others:
            first.others += (other, *_taken_from(other))
    return first


def _taken_from(error: LaunchFileError) -> tuple[LaunchFileError, ...]:
    if not isinstance(error, FrontendError):
        return ()
    taken, error.others = error.others, ()
    return taken


def as_lark_error(error: FrontendError) -> FrontendError:
    """Let an error of a substitution also be the one of lark that ROS 2 raises.

    Only if somebody has imported lark: who has not cannot catch its exceptions.
    """
    raised = getattr(sys.modules.get("lark.exceptions"), error.ros_type, None)
    if raised is None or isinstance(error, raised):
        return error
    own = type(error)
    original = error.__cause__ or own(error.message)
    error.__class__ = type(own.__name__, (own, raised), {"__str__": own.__str__})
    vars(error).update(rule="substitution", obj=None, orig_exc=original)
    return error


# Attributes of ROS 1 or of similar tags, and what to use instead.
_OTHER_NAMES = {
    ("arg", "value"): "'default' suggests a value, <let> sets one",
    ("for_each", "iter"): "use 'values'",
    ("arg", "choices"): "'choice' takes a list of mappings with the key 'value'",
    ("include", "ns"): "put it into a <group> with a <push_ros_namespace namespace=.../>",
    ("node", "executable"): "use 'exec'",
    ("node", "ns"): "use 'namespace'",
    ("node", "package"): "use 'pkg'",
    ("node", "type"): "use 'exec'",
    ("param", "if"): "choose the value: $(if CONDITION VALUE OTHER)",
    ("param", "unless"): "choose the value: $(if CONDITION OTHER VALUE)",
    ("group", "ns"): "use push_ros_namespace within the group",
    ("node", "required"): "use on_exit: shutdown",
    ("node", "clear_params"): "not in ROS 2: every node has its own parameters",
}


def attribute_hint(tag: str, name: str, known: Iterable[str]) -> str | None:
    """A hint for an attribute that the tag does not have."""
    return _OTHER_NAMES.get((tag, name)) or did_you_mean(name, sorted(known))


def missing_hint(tag: str, name: str, present: Iterable[str]) -> str | None:
    """A hint for a missing attribute: a similar one that is present."""
    for other in present:
        if f"'{name}'" in _OTHER_NAMES.get((tag, other), ""):
            return f"ROS 2 uses '{name}' instead of '{other}'"
    near = suggest(name, sorted(present))
    return f"is '{near}' a typo of '{name}'?" if near else None


def count_of(error: LaunchFileError) -> int:
    """The number of errors that an error reports."""
    return 1 + len(getattr(error, "others", ()))


def shown(text: object) -> str:
    """A text for a message, shortened to about a line."""
    found = str(text)
    return found if len(found) <= _SHOWN else f"{found[:_SHOWN]}..."


def locate(error: LaunchFileError, place: SourcePlace | None) -> None:
    """Set the place of an error, unless it has one."""
    if place is not None and error.where is None:
        error.where = place.where
        error.source_line = place.source_line
        error.column = place.column
