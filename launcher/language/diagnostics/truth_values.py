"""Conditions and their values: which launch configurations they read, and where those were set."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.language.substitution import Substitution, describe_substitutions, plain_text
from launcher.language.substitutions.configuration import LaunchConfiguration
from launcher.text import suggest

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_MAX_NESTING = 20  # of substitutions; deeper ones are not searched
_TRUE = ("true", "yes", "y", "on", "t", "ja", "enable", "enabled")
_FALSE = ("false", "no", "n", "off", "f", "none", "nein", "disable", "disabled")


def configurations_in(part: Any, depth: int = _MAX_NESTING) -> Iterator[str]:
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


def add_source(error: Any, context: LaunchContext, expression: Any, value: str) -> None:
    """Attach to an error about a truth value where the value came from, and the near one."""
    names = list(dict.fromkeys(configurations_in(list(expression))))
    near = near_truth(value)
    if len(names) == 1 and context.launch_configurations.peek(names[0]) is not None:
        (name,) = names
        origin = context.launch_configurations.origin_of(name)
        where = "on the command line" if origin is None else f"set at {origin}"
        error._launcher_hint = f"{name} is '{context.launch_configurations.peek(name)}', {where}"
        error._launcher_word = name
        if near:
            meant = f"{name}:={near}" if origin is None else f"'{near}'"
            error._launcher_hint += f"; did you mean {meant}?"
        return
    source = describe_substitutions(expression)
    if source != f"'{value}'":
        error._launcher_hint = f"{source} is '{value}'" + (f"; write {near}" if near else "")
    elif near:
        error._launcher_hint = f"write {near}"


def add_choice(error: Any, context: LaunchContext, name: str, choices: list[str]) -> None:
    """Attach where a value outside of `choices` came from, and the near choice."""
    configurations = context.launch_configurations
    value, origin = str(configurations.peek(name)), configurations.origin_of(name)
    where = "on the command line" if origin is None else f"set at {origin}"
    near = near_choice(value, choices)
    meant = f"; did you mean '{near}'?" if near else ""
    error._launcher_hint = f"{name} is '{value}', {where}{meant}"
    error._launcher_word = name


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
