"""Sentences for errors of the expressions of launch files: the expression, and what to write."""

from __future__ import annotations

from launcher.base.text import typed_error
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.truth_values import configurations_in

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_SHOWN = 120  # characters of an expression in a message


def explain(error: BaseException, text: str, expression: object, context: LaunchContext) -> None:
    """Attach the expression, its place and a hint to an error of its evaluation."""
    shown = text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}..."
    problem = error.msg if isinstance(error, SyntaxError) else typed_error(error)
    known = details(error)
    known.message = f"in the Python expression `{shown}`: {problem}"
    origin = getattr(expression, "_origin", None)
    if origin is not None:
        known.place = origin
    known.word = "eval" if _is_markup(origin) else "PythonExpression"
    name = getattr(error, "name", None) if isinstance(error, NameError) else None
    if name:
        known.hint = _quoted(name, expression, context)


def _quoted(name: str, expression: Any, context: LaunchContext) -> str:
    """How to write a text that Python took for a name."""
    configurations: Any = context.launch_configurations
    peek = getattr(configurations, "peek", configurations.get)
    sources = [one for one in configurations_in(expression.expression) if peek(one) == name]
    if not sources:
        return f"if it is a text, put it in quotes: '{name}'"
    source = sources[0]
    if _is_markup(getattr(expression, "_origin", None)):
        return f"it is the value of {source}: put it in quotes, as in '$(var {source})'"
    written = f"\"'\", LaunchConfiguration('{source}'), \"'\""
    return f"it is the value of {source}: put it in quotes, as in [{written}, ...]"


def _is_markup(origin: Any) -> bool:
    return origin is not None and not origin.is_python
