"""Conditions and their values: which launch configurations they read, and where those were set."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.text import suggest
from launcher.language.diagnostics.error_details import details
from launcher.language.substitution import Substitution, describe_substitutions, plain_text
from launcher.language.substitutions.configuration import LaunchConfiguration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_NESTING = 20  # of substitutions; deeper ones are not searched
_TRUE = ("true", "yes", "y", "on", "t", "ja", "enable", "enabled")
_FALSE = ("false", "no", "n", "off", "f", "none", "nein", "disable", "disabled")


def configurations_in(part: object, depth: int = _MAX_NESTING) -> Iterator[str]:
    """Names of the launch configurations that a condition or a substitution reads."""
    if depth == 0:
        return
    if isinstance(part, LaunchConfiguration):
        name = plain_text(part.variable_name)
        if name is not None:
            yield name
    elif isinstance(part, Substitution) or hasattr(type(part), "evaluate"):
        if hasattr(part, "launch_configuration_name"):
            yield part.launch_configuration_name
        for value in vars(part).values():
            yield from configurations_in(value, depth - 1)
    elif isinstance(part, (list, tuple)):
        for item in part:
            yield from configurations_in(item, depth - 1)


def add_source(error: BaseException, context: LaunchContext, expression: Any, value: str) -> None:
    """Attach to an error about a truth value where the value came from, and the near one."""
    configurations: Any = getattr(context, "launch_configurations", None)
    if not hasattr(configurations, "peek"):
        return  # a context of a test, not of a run
    names = dict.fromkeys(configurations_in(list(expression)))
    known = [name for name in names if configurations.peek(name) is not None]
    near = near_truth(value)
    if not known:
        source = describe_substitutions(expression)
        parts = [f"{source} is '{value}'"] if source.lower() != f"'{value}'" else []
        parts += [f"did you mean {near}?"] if near else []
        details(error).hint = "; ".join(parts) or None
        return
    parts = [_source(context, name) for name in known]
    if near and len(known) == 1:
        is_given = configurations.origin_of(known[0]) is None
        meant = f"{known[0]}:={near}" if is_given else f"'{near}'"
        parts.append(f"did you mean {meant}?")
    details(error).hint = "; ".join(parts)
    details(error).word = known[0]


def _source(context: LaunchContext, name: str) -> str:
    """The value of a launch configuration, and where it was set."""
    configurations = context.launch_configurations
    origin = configurations.origin_of(name)
    kind = "default" if configurations.is_default(name) else "set"
    where = "on the command line" if origin is None else f"{kind} at {origin}"
    return f"{name} is '{configurations.peek(name)}', {where}"


def add_choice(error: BaseException, context: LaunchContext, name: str, choices: list[str]) -> None:
    """Attach where a value outside of `choices` came from, and the near choice."""
    near = near_choice(str(context.launch_configurations.peek(name)), choices)
    meant = f"; did you mean '{near}'?" if near else ""
    details(error).hint = _source(context, name) + meant
    details(error).word = name


def near_choice(value: str, choices: list[str]) -> str | None:
    """The choice that was probably meant."""
    truth = near_truth(value)
    return suggest(value, choices) or (truth if truth in choices else None)


def near_truth(value: str) -> str | None:
    """`true` or `false`, whichever was probably meant."""
    word = value.strip().lower()
    for truth, words in (("true", _TRUE), ("false", _FALSE)):
        if word in words:
            return truth
    return suggest(word, ["true", "false"])
