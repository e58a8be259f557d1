"""Hints for exceptions of launch files."""

from __future__ import annotations

import re

from launcher.base.errors import LauncherError
from launcher.base.text import did_you_mean
from launcher.language.diagnostics import import_hints
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.keywords import OF_MARKUP

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine

ENDLESS = "remove an include or a call, or give it a condition that becomes false"
_UNKNOWN_KEYWORD = re.compile(r"unexpected keyword argument '(\w+)'")
_MISSING_CONFIGURATION = re.compile(r"launch configuration '(.*)' does not exist")
_MISSING_VARIABLE = re.compile(r"environment variable '(.*)' does not exist")
_EXPANDED = re.compile(r"(^invalid condition expression, .*), expanded from '.*'$")
_NOT_PROVIDED = re.compile(r" \((did you mean \w+\?)? ?provided: (.*)\)$")


def hint(
    error: BaseException, message: str, context: LaunchContext | None, place: FileLine | None
) -> str | None:
    if (known := details(error).hint) is not None:
        return known
    if isinstance(error, LauncherError):
        return error.hint
    if isinstance(error, RecursionError):
        return ENDLESS
    for pattern, suggest in _SUGGESTIONS:
        found = pattern.search(message)
        if found:
            return suggest(found[1], context, place is None or place.is_python)
    elsewhere = import_hints.hint(error, message)
    if elsewhere is not None:
        return elsewhere
    provided = _NOT_PROVIDED.search(message)
    if provided:
        return provided[1] or f"provided: {provided[2]}"
    return None


def declared_below(message: str, place: FileLine | None) -> str | None:
    """The hint for a launch configuration that is read before its argument is declared."""
    found = _MISSING_CONFIGURATION.search(message)
    if found is None or place is None:
        return None
    line = _declaration(found[1], place)
    if line is None:
        return None
    return f"'{found[1]}' is declared below, in line {line}; move the declaration in front"


def _declaration(name: str, place: FileLine) -> int | None:
    """The line, from `place` on, that declares the argument."""
    import linecache

    quoted = rf"['\"]?{re.escape(name)}['\"]?"
    declared = re.compile(
        rf"Declare(?:Boolean)?LaunchArgument\(\s*(?:name\s*=\s*)?{quoted}\s*[,)]"
        rf"|<(?:bool_)?arg\b[^>]*\bname\s*=\s*{quoted}[\s/>]"
        rf"|-\s+(?:bool_)?arg:\s*\n?\s*\{{?\s*name:\s*{quoted}\s*[,}}\n]"
    )
    text = "".join(linecache.getlines(place.path)[place.line - 1 :])
    match = declared.search(text)
    return None if match is None else place.line + text.count("\n", 0, match.start())


def without_hint(message: str) -> str:
    """The message without what the hint says: known names, the source of a condition."""
    return _EXPANDED.sub(r"\1", _NOT_PROVIDED.sub("", message))


def _near_keyword(name: str, context: LaunchContext | None, in_python: bool) -> str | None:
    meant = OF_MARKUP.get(name)
    return f"did you mean '{meant}'?" if meant else did_you_mean(name, _keywords())


def _near_configuration(name: str, context: LaunchContext | None, in_python: bool) -> str | None:
    if context is None:
        return None
    declaration = "DeclareLaunchArgument" if in_python else "<arg>"
    return did_you_mean(name, list(context.launch_configurations)) or (
        f"declare it with {declaration}, or give {name}:=VALUE"
    )


def _near_variable(name: str, context: LaunchContext | None, in_python: bool) -> str | None:
    if context is None:
        return None
    default = f"write $(env {name} DEFAULT)"
    if in_python:
        default = "give EnvironmentVariable a default_value"
    return did_you_mean(name, list(context.environment)) or (
        f"set it (export {name}=VALUE), or {default}"
    )


def _no_function(name: str, context: LaunchContext | None, in_python: bool) -> str:
    return f"define {name}() that returns a LaunchDescription"


_SUGGESTIONS = (
    (_UNKNOWN_KEYWORD, _near_keyword),
    (_MISSING_CONFIGURATION, _near_configuration),
    (_MISSING_VARIABLE, _near_variable),
    (re.compile(r"does not contain the required function '(\w+)\(\)'"), _no_function),
)


def _keywords() -> set[str]:
    """The keyword arguments of all action classes."""
    import inspect

    from launcher.language.action import Action

    found: set[str] = set()
    waiting: list[type] = [Action]
    while waiting:
        cls = waiting.pop()
        waiting += cls.__subclasses__()
        found.update(inspect.signature(cls).parameters)
    return found
