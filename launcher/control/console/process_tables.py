"""Tables for `ps`, `top`, `info` and `help`, as wide as the terminal."""

from __future__ import annotations

import io
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from rich.cells import cell_len
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from launcher.base.text import count
from launcher.control.answer_lines import (
    concern,
    filters,
    first_of,
    folder,
    log_file,
    readiness,
    variables,
)
from launcher.control.console.short_forms import (
    cpu,
    duration,
    end_cut,
    is_in_trouble,
    memory,
    middle_cut,
)

Process = Mapping[str, Any]  # a row of `ps`, `top` or `info`

GAP = 2  # blanks between two columns
MIN_TEXT = 40  # columns for texts beside names
MIN_REST = 10  # columns for a last exit; with fewer it is not shown
MAX_FAULTS = 30
MIN_NAME, MIN_STATE, MIN_SHOWN = 14, 8, 16
NAME_PART, STATE_PART, SHOWN_PART = 0.4, 0.3, 0.25  # of the width, if not all columns fit
_STATE_STYLES = {"running": "green", "backoff": "yellow", "stopping": "yellow"}


def render(what: RenderableType, columns: int, *, colour: bool) -> str:
    """As text, no line longer than `columns`."""
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
    lines = file.getvalue().removesuffix("\n").split("\n")
    return "\n".join(map(str.rstrip, lines))


def details(process: Process) -> Table:
    """`info` of one process."""
    rows: list[tuple[str, RenderableType]] = []
    for name, value in _facts(process):
        lines = value if isinstance(value, list) else [value]
        rows += [("" if index else name, line) for index, line in enumerate(lines)]
    return pairs(rows)


def _facts(one: Process) -> Iterable[tuple[str, RenderableType | list[str]]]:
    yield "name", Text(one["name"], "bold")
    if "host" in one:
        yield "host", one["host"]
    if one.get("unit"):
        yield "unit", one["unit"]
    yield "state", state(one)
    if one.get("faults"):
        yield "faults", list(one["faults"])
    if "ready" in one:
        yield "ready", readiness(one) or "-"
    yield "pid", _text(one["pid"])
    yield "started", _text(one.get("start_text"))
    yield "up", _text(one["uptime_s"], duration)
    yield "nodes", list(one["node_names"]) or "-"
    yield "command", shlex.join(one["cmd"])
    yield "folder", folder(one)
    yield "restarts", f"{one['restarts']}; policy: {one['restart_policy']}"
    yield "stop", one["stop_policy"]
    last = one["last_exit"]
    asked = " (requested)" if last and last["asked"] else ""
    yield "last exit", f"{last['text']}{asked}" if last else "-"
    yield "cpu", _text(one["cpu_percent"], cpu)
    resident = _text(one["rss_bytes"], memory)
    yield "memory", f"{_text(one['uss_bytes'], memory)} USS, {resident} RSS"
    yield "threads", _text(one["threads"])
    yield "open files", _text(one["fds"])
    yield "shown", filters(one) or "all"
    if one.get("watched_files"):
        yield "watched", count(one["watched_files"], "file")
    yield "log", log_file(one)
    yield "environment", variables(one) or "unchanged"


def _text(value: Any, form: Any = str) -> str:
    return "-" if value is None else form(value)


def stacked(parts: Sequence[RenderableType]) -> Group:
    """The parts below each other, with an empty line between them."""
    return Group(*[piece for part in parts for piece in (part, "")][:-1])


def pairs(rows: Iterable[tuple[str, RenderableType]]) -> Table:
    """Two columns; long texts in the second are folded."""
    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def manual(rows: Sequence[tuple[str, str]], columns: int) -> RenderableType:
    """`pairs`, or each text below its name where it would be folded in a narrow column."""
    names, texts = (max(cell_len(row[place]) for row in rows) for place in (0, 1))
    if names + GAP + min(texts, MIN_TEXT) <= columns:
        return pairs(rows)
    pieces: list[RenderableType] = []
    for name, text in rows:
        pieces += [Text(name, "bold", overflow="fold")]
        pieces += [Padding(Text(text, overflow="fold"), (0, 0, 0, GAP))] if text else []
    return Group(*pieces)


class Column(NamedTuple):
    """A column; the lowest `dropped` goes first where there is no room, 0 never goes."""

    title: str
    cell: Callable[[Process], Text]
    dropped: int = 0
    is_left: bool = False


def _figure(key: str, form: Callable[[Any], str] = str) -> Callable[[Process], Text]:
    def cell(process: Process) -> Text:
        value = process.get(key)
        return Text("-" if value is None else form(value))

    return cell


def state(process: Process) -> Text:
    """State of a process; with its last exit, unless it runs; with what else concerns it."""
    word = "paused" if process.get("paused") else process["state"].lower()
    if concern(process):
        return Text(f"{word}, {concern(process)}", "yellow")
    if process.get("paused"):
        return Text(word, "yellow")
    if process.get("waiting_for"):
        return Text(readiness(process), "yellow")
    if process.get("lacks"):
        return Text(f"{word}, {readiness(process)}", "yellow")
    last = process.get("last_exit")
    text = f"{word}: {last['text']}" if process.get("pid") is None and last else word
    return Text(text, _STATE_STYLES.get(word, "red" if is_in_trouble(process) else ""))


def _faults(process: Process) -> Text:
    return Text(end_cut(first_of(process.get("faults")), MAX_FAULTS), "red")


COLUMNS = (
    Column("name", lambda process: Text(process["name"]), is_left=True),
    Column("state", state, is_left=True),
    Column("host", _figure("host"), 8, is_left=True),
    Column("pid", _figure("pid"), 2),
    Column("restarts", lambda process: Text(str(process.get("restarts") or "-")), 5),
    Column("up", _figure("uptime_s", duration), 3),
    Column("cpu", _figure("cpu_percent", cpu), 7),
    Column("USS", _figure("uss_bytes", memory), 6),
    Column("threads", _figure("threads"), 1),
    Column("start", _figure("start"), 1, is_left=True),
    Column("faults", _faults, 9, is_left=True),
    Column("shown", lambda process: Text(filters(process) or "all"), 4, is_left=True),
)


def process_table(found: Sequence[Process], columns: int, *, has_head: bool = True) -> Table:
    """One row per process, at most so many columns wide."""
    has_hosts = any("host" in process for process in found)
    left_out = {"host"} if not has_hosts else set()
    if all(process.get("start") != "warm" for process in found):
        left_out.add("start")
    if not any(process.get("faults") for process in found):
        left_out.add("faults")
    shown = [column for column in COLUMNS if column.title not in left_out]
    cells = {column: [column.cell(process) for process in found] for column in shown}
    widths = _widths(cells, columns)
    table = Table(
        box=None, pad_edge=False, header_style="bold", padding=(0, GAP, 0, 0), show_header=has_head
    )
    for column, width in widths.items():
        justify = "left" if column.is_left else "right"
        title = column.title[:width]
        table.add_column(title, no_wrap=True, justify=justify, width=width, overflow="crop")  # type: ignore[arg-type]
    for place in range(len(found)):
        table.add_row(*(_cut(column, cells[column][place], w) for column, w in widths.items()))
    return table


def _widths(cells: Mapping[Column, Sequence[Text]], columns: int) -> dict[Column, int]:
    """Width of each column that fits, in order."""
    widths = {
        column: max([cell_len(column.title), *(cell.cell_len for cell in texts)])
        for column, texts in cells.items()
    }
    wanted = dict(widths)
    if _total(widths) > columns:
        name, state, *_, shown = COLUMNS
        for column, least, part in (
            (name, MIN_NAME, NAME_PART),
            (state, MIN_STATE, STATE_PART),
            (shown, MIN_SHOWN, SHOWN_PART),
        ):
            widths[column] = min(widths[column], max(least, int(columns * part)))
    for column in sorted((c for c in cells if c.dropped), key=lambda c: c.dropped):
        if _total(widths) > columns:
            del widths[column]
    return _adjusted(widths, wanted, columns)


def _adjusted(
    widths: dict[Column, int], wanted: Mapping[Column, int], columns: int
) -> dict[Column, int]:
    """Give the rest of the width to columns that were cut; take excess from the names."""
    for column in widths:
        room = columns - _total(widths)
        widths[column] += min(max(0, room), wanted[column] - widths[column])
    name, state = COLUMNS[:2]
    excess = _total(widths) - columns
    if excess > 0:
        widths[name] = max(min(widths[name], MIN_NAME // 2), widths[name] - excess)
    if _total(widths) > columns:
        del widths[state]
        widths[name] = max(1, min(wanted[name], columns))
    return widths


def _total(widths: Mapping[Column, int]) -> int:
    return sum(widths.values()) + GAP * (len(widths) - 1)


def _cut(column: Column, cell: Text, width: int) -> Text:
    """The cell in `width` columns: names are cut in the middle, states lose the last exit."""
    if cell.cell_len <= width:
        return cell
    text = cell.plain
    if column is COLUMNS[0]:
        return Text(middle_cut(text, width), cell.style)
    word, _, rest = text.partition(":")
    if rest and cell_len(word) <= width < cell_len(word) + MIN_REST:
        return Text(word, cell.style)
    return Text(end_cut(text, width), cell.style)
