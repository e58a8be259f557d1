"""Parse functions of `executable`, which `node` shares."""

from __future__ import annotations

import shlex
from collections.abc import Collection

from launcher.language.frontends.entity import Entity
from launcher.language.frontends.errors import AttributeTypeError, UnexpectedContentError, shown
from launcher.language.frontends.parsers.attributes import (
    Parsed,
    as_dictionary,
    name_value_pairs,
    parse_action,
)
from launcher.language.substitution import TextSubstitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.frontends.parser import Parser

# Keyword of the constructor -> attribute, for those that are texts with substitutions.
_TEXTS = {
    "cwd": "cwd",
    "name": "name",
    "prefix": "launch-prefix",
    "output": "output",
    "respawn": "respawn",
}
_TIMEOUTS = ("sigkill_timeout", "sigterm_timeout")


def parse_process(
    cls: Any, entity: Entity, parser: Any, ignore: Collection[str] | None = None
) -> Parsed:
    """`executable`; `ignore` names keywords that a subclass parses itself."""
    _, arguments = parse_action(cls, entity, parser)
    ignored = ignore or ()
    if "cmd" not in ignored:
        arguments["cmd"] = cls._parse_cmdline(entity.get_attr("cmd"), parser)
    for keyword, attribute in _TEXTS.items():
        text = entity.get_attr(attribute, optional=True) if keyword not in ignored else None
        if text is not None:
            arguments[keyword] = parser.parse_substitution(text)
    if "on_exit" not in ignored:
        _add_on_exit(arguments, entity)
    _add_typed(arguments, entity, ignored)
    if "additional_env" not in ignored:
        env = name_value_pairs(entity, parser, "env")
        if env is not None:
            arguments["additional_env"] = as_dictionary(env)
    return cls, arguments


def _add_on_exit(arguments: dict[str, Any], entity: Entity) -> None:
    on_exit = entity.get_attr("on_exit", optional=True)
    if on_exit is None:
        return
    if on_exit != "shutdown":
        message = f"'on_exit' can only be 'shutdown', not '{on_exit}'"
        raise UnexpectedContentError(message, place=entity.place)
    from launcher.language.actions.event_actions import Shutdown

    arguments["on_exit"] = [Shutdown()]


def _add_typed(arguments: dict[str, Any], entity: Entity, ignored: Collection[str]) -> None:
    types = {"respawn_max_retries": int, "shell": bool, "emulate_tty": bool}
    for name, data_type in types.items():
        if name not in ignored:
            value = entity.get_attr(name, data_type=data_type, optional=True)
            if value is not None:
                arguments[name] = value
    for name in ("respawn_delay", *_TIMEOUTS):
        value = _seconds(entity, name) if name not in ignored else None
        if value is not None:
            arguments[name] = str(value) if name in _TIMEOUTS else value


def _seconds(entity: Entity, name: str) -> Any:
    """A number of seconds; ROS 2 takes no substitutions here."""
    value = entity.get_attr(name, data_type=float, optional=True)
    if isinstance(value, str):
        message = f"'{name}' should be a number of seconds, not '{value}'"
        raise AttributeTypeError(message, place=entity.place)
    if value is not None and value < 0.0:
        message = f"'{name}' should not be negative, it is {value}"
        raise UnexpectedContentError(message, place=entity.place)
    return value


def parse_words(cls: type, cmd: str, parser: Parser) -> list[list[Any]]:
    """The words of a command line, each a list of substitutions.

    Only literal text is split; the value of a substitution stays in its word. Each text between
    substitutions is split separately, so quotes cannot enclose a substitution.
    """
    words: list[list[Any]] = []
    word: list[Any] = []
    for part in parser.parse_substitution(cmd):
        if not isinstance(part, TextSubstitution):
            word.append(part)
            continue
        tokens = _split(part.text, cmd)
        if not tokens or (part.text[0].isspace() and word):
            words.append(word)
            word = []
        for token in tokens[:-1]:
            words.append([*word, TextSubstitution(text=token)])
            word = []
        if tokens:
            word.append(TextSubstitution(text=tokens[-1]))
            if part.text[-1].isspace():
                words.append(word)
                word = []
    return [*words, word] if word else words


def _split(text: str, cmd: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError as problem:
        raise UnexpectedContentError(
            f"in '{shown(cmd)}': {problem}",
            hint="remove the quotes: the value of a substitution is always one word"
            if "$(" in cmd
            else None,
        ) from problem
