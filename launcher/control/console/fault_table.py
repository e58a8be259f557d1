"""The table of `faults`, as wide as the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from launcher.base.text import escape
from launcher.control.console.process_tables import GAP
from launcher.control.fault_texts import (
    NO_FAULT,
    NOT_WATCHING,
    arranged,
    left_lines,
    mute_lines,
    reason_text,
    since,
    state_word,
)

WIDE = 110  # columns from which a cause has a column, and else follows what was seen
INDENT = 2  # of a fault that follows from another
_STYLES = {
    "active": "red",
    "acknowledged": "yellow",
    "suspected": "yellow",
    "muted": "dim",
    "healed": "green",
}


def fault_table(result: Mapping[str, Any], columns: int) -> RenderableType:
    """The answer of `faults`: a row for each fault, and what is left to smoke."""
    faults = result["faults"]
    is_watching = result.get("watching", True)
    parts: list[RenderableType] = [_table(faults, columns)] if faults else []
    if not is_watching:
        parts.append(Text(NOT_WATCHING, "yellow"))
    elif not faults:
        parts.append(Text(NO_FAULT))
    parts += [Text(line, "dim") for line in mute_lines(result.get("mutes", ()), faults)]
    parts += [Text(line, "dim") for line in left_lines(result.get("left_to_smoke", ()))]
    return Group(*parts)


def _table(faults: Iterable[Mapping[str, Any]], columns: int) -> Table:
    is_wide = columns >= WIDE
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, GAP, 0, 0))
    for title in ("state", "fault", "since", "seen", *(("cause",) if is_wide else ())):
        table.add_column(title, overflow="fold", no_wrap=title == "state")
    for depth, fault in arranged(faults):
        word, seen = state_word(fault), _text(fault["seen"])
        cause = _text("" if fault["cause"] in (None, fault["seen"]) else fault["cause"])
        times = f" x{fault['count']}" if fault["count"] > 1 else ""
        if not is_wide and cause:
            seen = Text("\n").join([seen, Text.assemble("because: ", cause, style="dim")])
        table.add_row(
            Text(f"{word}{times}", _STYLES.get(word, "")),
            Padding(_name(fault), (0, 0, 0, INDENT * depth)),
            Text(since(fault)),
            seen,
            *((cause,) if is_wide else ()),
        )
    return table


def _name(fault: Mapping[str, Any]) -> Text:
    """With the reason of a user, if there is one, below."""
    reason = reason_text(fault)
    return _text(fault["fault"]) + (Text("\n") + _text(reason) if reason else Text())


def _text(text: str) -> Text:
    return Text(escape(str(text), keep="\n"))
