"""Talk: a line that a person typed, asked of the run and answered in text."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from launcher.console import tables
from launcher.console.process_table import process_table
from launcher.control.client import Reply
from launcher.control.folder import ControlError
from launcher.control.runs import Run
from launcher.control.verbs import VERBS, Call, find, parse
from launcher.errors import LauncherError, UsageError, nearest

KEYS = (
    ("Tab", "complete a verb, a name, a pattern, a signal"),
    ("Up, Ctrl-R", "lines that were typed before"),
    ("Ctrl-C", "stop everything; again: do not wait"),
    ("Ctrl-D", "the same as quit"),
    ("Ctrl-Z", "suspend; fg goes on"),
)


def read_call(line: str) -> Call:
    """What the line asks for; UsageError."""
    try:
        name, *words = shlex.split(line)
    except ValueError as error:
        raise UsageError(f"the line is not finished: {error}") from None
    verb = find(name)
    if verb is None:
        near = nearest(name, [verb.name for verb in VERBS])
        hint = f"did you mean {near}?" if near else "`help` lists what there is"
        raise UsageError(f"there is no verb '{name}'", hint=hint)
    return parse(verb, words)


def follows(call: Call) -> bool:
    """Whether its answer does not end; `top` is live unless it is asked otherwise."""
    return call.verb.streams and (call.verb.name == "top" or bool(call.options.get("follow")))


def answer(run: Run, call: Call, columns: int, *, colour: bool) -> str:
    """Ask, wait, and put into words; errors, too."""
    if call.verb.name == "help" and "topic" not in call.options:
        return tables.render(_help(), columns, colour=colour)
    try:
        with run.connect() as connection:
            reply = connection.ask(call.verb.name, call.names, **call.options)
    except ControlError as error:
        return problem(error, colour=colour)
    made = _table(call, reply, columns)
    return "\n".join(reply.text) if made is None else tables.render(made, columns, colour=colour)


def problem(error: LauncherError, *, colour: bool) -> str:
    """The error as it is printed."""
    text = error.render()
    first, newline, rest = text.partition("\n")
    return f"\x1b[31m{first}\x1b[0m{newline}{rest}" if colour else text


def _help() -> RenderableType:
    return tables.pairs([*((verb.usage, verb.help) for verb in VERBS), ("", ""), *KEYS])


def _table(call: Call, reply: Reply, columns: int) -> RenderableType | None:
    found = reply.result.get("processes")
    if call.verb.name == "ps" and found is not None:
        return process_table(found, columns)
    if call.verb.name == "info" and found:
        return tables.several([tables.about(one) for one in found])
    return None


Hear = Callable[[Mapping[str, Any]], None]


def item_text(call: Call, item: Mapping[str, Any]) -> str:
    """An item of `logs -f` or `events -f` as a line."""
    if "dropped" in item:
        return f"({item['dropped']} lines left out: they came too fast)"
    if call.verb.name == "logs":
        name = item.get("process") or "launch"
        return f"[{name}] {item['text']}"
    return " ".join(f"{key}={value}" for key, value in item.items())


def items(connection: Any, call: Call) -> Iterator[dict[str, Any]]:
    """The items of a call that does not end, till the connection is closed."""
    options = {key: value for key, value in call.options.items() if key != "follow"}
    yield from connection.follow(call.verb.name, call.names, **options)
