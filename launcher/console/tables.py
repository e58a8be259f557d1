"""Tables: what verbs answer, laid out by rich for the width of the terminal (`process_table`)."""

from __future__ import annotations

import io
import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from launcher.console.figures import cpu, duration, memory
from launcher.console.process_table import shown, state


def render(what: RenderableType, columns: int, *, colour: bool) -> str:
    """The text, with colours or without, no line of it wider than the terminal."""
    file = io.StringIO()
    console = Console(
        file=file,
        width=columns,
        force_terminal=colour,
        color_system="standard" if colour else None,
        no_color=not colour,
        highlight=False,
        markup=False,
        emoji=False,
        legacy_windows=False,
    )
    console.print(what)
    return "\n".join(line.rstrip() for line in file.getvalue().splitlines())


def about(process: Mapping[str, Any]) -> Table:
    """The answer to `info` for one process."""
    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in _facts(process):
        for index, line in enumerate(value if isinstance(value, list) else [value]):
            table.add_row("" if index else name, line)
    return table


def _facts(one: Mapping[str, Any]) -> Iterable[tuple[str, RenderableType | list[str]]]:
    yield "name", Text(one["name"], "bold")
    yield "state", state(one)
    yield "pid", _text(one["pid"])
    yield "up", _text(one["uptime_s"], duration)
    yield "nodes", list(one["node_names"]) or "-"
    yield "command", shlex.join(one["command"])
    yield "folder", one["cwd"] or "that of the launcher"
    yield "restarts", f"{one['restarts']}; policy: {one['restart_policy']}"
    yield "stop", one["stop_policy"]
    last = one["last_exit"]
    asked = " (asked)" if last and last["asked"] else ""
    yield "last exit", f"{last['text']}{asked}" if last else "-"
    yield "cpu", _text(one["cpu_percent"], cpu)
    resident = _text(one["rss_bytes"], memory)
    yield "memory", f"{_text(one['memory_bytes'], memory)} (resident {resident})"
    yield "threads", _text(one["threads"])
    yield "open files", _text(one["fds"])
    yield "shown", shown(one)
    yield "log", _text(one["log_file"])
    unset = [f"{name} is not set" for name in one["environment_unset"]]
    yield "environment", [f"{k}={v}" for k, v in one["environment_set"].items()] + unset or "-"


def _text(value: Any, form: Any = str) -> str:
    return "-" if value is None else form(value)


def several(parts: Sequence[RenderableType]) -> Group:
    """One below the other, with an empty line between them."""
    return Group(*[piece for part in parts for piece in (part, "")][:-1])


def pairs(rows: Iterable[tuple[str, str]]) -> Table:
    """Two columns, as `help` has them."""
    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for left, right in rows:
        table.add_row(left, right)
    return table
