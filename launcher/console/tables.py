"""Tables: what verbs answer, laid out by rich for the width of the terminal."""

from __future__ import annotations

import io
import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from launcher.console.figures import cpu, duration, memory
from launcher.console.trouble import is_in_trouble

NARROW = 60  # columns; below it only the most important ones are shown


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


def processes(found: Sequence[Mapping[str, Any]], columns: int, rows: int | None = None) -> Table:
    """The answer to `ps`; with `rows`, those in trouble and those that use most come first."""
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    wide = columns >= NARROW
    for title in ("name", "state", *(("pid", "restarts", "up") if wide else ())):
        table.add_column(title, no_wrap=True, justify="left" if title in _LEFT else "right")
    for title in ("cpu", "memory", *(("threads", "shown") if wide else ())):
        table.add_column(title, no_wrap=True, justify="left" if title in _LEFT else "right")
    left_out = 0
    if rows is not None and len(found) > rows:
        left_out = len(found) - max(0, rows - 1)
        found = sorted(found, key=_importance)[: max(0, rows - 1)]
    for process in found:
        table.add_row(*_row(process, wide=wide))
    if left_out:
        table.add_row(f"and {left_out} more")
    return table


_STATE_STYLES = {"running": "green", "backoff": "yellow", "stopping": "yellow"}
_LEFT = ("name", "state", "shown")


def _importance(process: Mapping[str, Any]) -> tuple[bool, float]:
    return not is_in_trouble(process), -(process.get("cpu_percent") or 0.0)


def _row(process: Mapping[str, Any], *, wide: bool) -> Iterable[RenderableType]:
    yield process["name"]
    yield _state(process)
    if wide:
        yield _text(process.get("pid"))
        yield _text(process.get("restarts") or None)
        yield _text(process.get("uptime_s"), duration)
    yield _text(process.get("cpu_percent"), cpu)
    yield _text(process.get("memory_bytes"), memory)
    if wide:
        yield _text(process.get("threads"))
        yield _shown(process)


def _text(value: Any, form: Any = str) -> str:
    return "-" if value is None else form(value)


def _state(process: Mapping[str, Any]) -> Text:
    if process.get("paused"):
        return Text("paused", "yellow")
    state = process["state"].lower()
    last = process.get("last_exit")
    text = f"{state}: {last['text']}" if process.get("pid") is None and last else state
    style = "red" if is_in_trouble(process) else ""
    return Text(text, _STATE_STYLES.get(state, style))


def _shown(process: Mapping[str, Any]) -> str:
    words = ["muted"] if process.get("muted") else []
    if process.get("level"):
        words.append(f"{process['level']} and above")
    if process.get("grep"):
        words.append(f"lines with {process['grep']!r}")
    if words:
        words.append(f"{process.get('muted_lines', 0)} lines not shown")
    return ", ".join(words) or "all"


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
    yield "state", _state(one)
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
    yield "shown", _shown(one)
    yield "log", _text(one["log_file"])
    unset = [f"{name} is not set" for name in one["environment_unset"]]
    yield "environment", [f"{k}={v}" for k, v in one["environment_set"].items()] + unset or "-"


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
