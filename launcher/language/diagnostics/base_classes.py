"""Mistakes in classes that a launch file derives from those of launch: a method is missing.

Only a missing `perform` is an error in ROS 2; the other methods do nothing in their base class.
"""

from __future__ import annotations

from launcher.base.text import suggest
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine, is_own_file

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


class NoPerformError(NotImplementedError):
    """A class of substitutions without `perform`; with hint and place for `faults.explain`."""

    ros_type = "NotImplementedError"

    def __init__(self, substitution: object) -> None:
        cls = type(substitution)
        super().__init__(f"the substitution {cls.__name__} has no method perform()")
        near = _near_method(cls, "perform")
        known = details(self)
        known.hint = (
            f"write 'def perform(self, context)' instead of 'def {near}'"
            if near
            else "write 'def perform(self, context)', which returns the text"
        )
        known.place = _place(cls, near) or getattr(substitution, "_origin", None)
        known.word = near or cls.__name__


def warn_of_idle_entity(entity: Any, context: LaunchContext, method: str) -> None:
    """An entity was visited whose class has neither `visit` nor `execute`: ROS 2 does nothing."""
    cls = type(entity)
    near = _near_method(cls, method)
    hint = f"write 'def {method}(self, context)'" + (f" instead of 'def {near}'" if near else "")
    text = f"{cls.__name__} does nothing, since it has no method {method}(); hint: {hint}"
    context._host.warn_quirk(text, _place(cls, near) or entity._origin)


def false_condition(condition: object, context: LaunchContext) -> None:
    """A condition was evaluated whose class has neither a predicate nor `evaluate`: false."""
    cls = type(condition)
    near = _near_method(cls, "evaluate")
    hint = "write 'def evaluate(self, context)'" + (f" instead of 'def {near}'" if near else "")
    text = f"{cls.__name__} is always false, since it has no method evaluate(); hint: {hint}"
    context._host.warn_quirk(text, _place(cls, near))


def _own_functions(cls: type) -> dict[str, Any]:
    """The functions of a class and its bases, without those of the launcher."""
    found: dict[str, Any] = {}
    for one in reversed(cls.__mro__):
        for name, value in vars(one).items():
            code = getattr(value, "__code__", None)
            if code is not None and not is_own_file(code.co_filename):
                found[name] = value
    return found


def _near_method(cls: type, wanted: str) -> str | None:
    return suggest(wanted, [name for name in _own_functions(cls) if not name.startswith("__")])


def _place(cls: type, method: str | None) -> FileLine | None:
    """The line of a method, else that of the class."""
    functions = _own_functions(cls)
    if method is not None:
        code = functions[method].__code__
        return FileLine(code.co_filename, code.co_firstlineno)
    import inspect

    try:
        path, (_, line) = inspect.getsourcefile(cls), inspect.getsourcelines(cls)
    except (OSError, TypeError):  # a class without a file
        return None
    return None if path is None else FileLine(path, line)
