"""Tables of a running run, drawn by rich: for the shell commands and the console."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

_STYLES = {
    "RUNNING": "green",
    "STOPPED": "dim",
    "EXITED": "dim",
    "FATAL": "bold red",
    "BACKOFF": "yellow",
    "STOPPING": "yellow",
    "PAUSED": "magenta",
}
_UNITS = ((3600.0, "h"), (60.0, "min"))


def process_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """`ps` and `top`: a row for each process of the result of `ps`."""
    table = _table(
        "process", "state", ">pid", ">restarts", ">uptime", ">CPU", ">memory", ">threads", "notes"
    )
    for row in rows:
        state = "PAUSED" if row["paused"] else row["state"]
        table.add_row(
            Text(row["name"], style="bold"),
            Text(state, style=_STYLES.get(state, "")),
            _plain(row["pid"]),
            str(row["restarts"]),
            duration(row["uptime_s"]),
            _plain(row["cpu_percent"], "{:.1f} %"),
            megabytes(row["memory_bytes"]),
            _plain(row["threads"]),
            Text(notes(row), style="dim"),
        )
    return table


def run_table(runs: Sequence[Mapping[str, Any]]) -> Table:
    """`runs`: a row for each run."""
    table = _table("run", ">pid", "target", "arguments", "since", ">processes", ">domain")
    for run in runs:
        table.add_row(
            Text(run["id"], style="bold"),
            str(run["pid"]),
            Text(run["target"], overflow="fold"),
            Text(" ".join(run["arguments"])),
            time.strftime("%H:%M:%S", time.localtime(run["started"])),
            str(len(run["processes"])),
            _plain(run["domain_id"]),
        )
    return table


def _table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim")
    for column in columns:
        name = column.removeprefix(">")
        table.add_column(name, justify="left" if name == column else "right", no_wrap=True)
    return table


def _plain(value: Any, form: str = "{}") -> str:
    return "-" if value is None else form.format(value)


def megabytes(size: int | None) -> str:
    """`48.1 MB`."""
    return _plain(None if size is None else size / 1e6, "{:.1f} MB")


def duration(seconds: float | None) -> str:
    """`4.2 s`, `3.4 min`, `2.1 h`."""
    if seconds is None:
        return "-"
    for length, unit in _UNITS:
        if seconds >= length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"


def notes(row: Mapping[str, Any]) -> str:
    """What is out of the ordinary: how it ended, what is not shown of it."""
    parts = []
    if row["pid"] is None and row["last_exit"] is not None:
        parts.append(row["last_exit"]["text"] + (", asked" if row["last_exit"]["asked"] else ""))
    shown = ["muted"] if row["muted"] else []
    shown += [f"{row['level']} and above"] if row["level"] else []
    shown += [f"lines with {row['grep']!r}"] if row["grep"] else []
    if shown:
        parts.append(f"{', '.join(shown)}: {row['muted_lines']} lines not shown")
    return "; ".join(parts)
