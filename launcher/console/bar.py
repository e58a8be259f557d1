"""The status bar: states of all processes in one line, in the longest form that fits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from prompt_toolkit.utils import get_cwidth

from launcher.console.format import cpu, ending, is_in_trouble, memory, middle_cut

Fragment = tuple[str, str]
Line = list[Fragment]

SEPARATOR = ("class:bar.quiet", " | ")
CUT = "..."
LONG_NAME, SHORT_NAME = 20, 12  # columns of names, before counts replace them
MIN_FOLDER = 10  # characters; what is shorter is not shown
_STYLES = {
    "RUNNING": "class:bar.running",
    "STARTING": "class:bar.waiting",
    "BACKOFF": "class:bar.waiting",
    "STOPPING": "class:bar.waiting",
    "FATAL": "class:bar.trouble",
}


def status_line(processes: Sequence[Mapping[str, Any]], columns: int) -> Line:
    """Names with CPU and memory, with CPU, alone, short names, or counts: the first that fits."""
    if not processes:
        return [("class:bar.quiet", "no processes")]
    names = short_names(processes)
    lines = [
        _joined([_cell(p, names[p["name"]], _figures(p)[:most]) for p in processes])
        for most in (2, 1)
    ]
    lines += [
        _joined([_cell(p, middle_cut(names[p["name"]], most)) for p in processes])
        for most in (columns, LONG_NAME, SHORT_NAME)
    ]
    for line in [*lines, *_counted(processes, names)]:
        if width(line) <= columns:
            return line
    return fitted(line, columns)


def short_names(processes: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Name -> label if that is unique, else name."""
    labels = Counter(p.get("label") or p["name"] for p in processes)
    return {
        p["name"]: p["label"] if p.get("label") and labels[p["label"]] == 1 else p["name"]
        for p in processes
    }


def width(line: Line) -> int:
    return sum(get_cwidth(text) for _, text in line)


def fitted(line: Line, columns: int) -> Line:
    if width(line) <= columns:
        return line
    room = max(0, columns - len(CUT))
    cut: Line = []
    for style, text in line:
        while get_cwidth(text) > room:
            text = text[:-1]
        cut.append((style, text))
        room -= get_cwidth(text)
        if room <= 0:
            break
    return [*cut, ("class:bar.quiet", CUT[:columns])]


def folder_line(folder: str, columns: int) -> Line:
    """A hint for newcomers and the log folder, whose end says most."""
    hint = "help | Ctrl-C stops the run"
    text = f"{hint} | {folder}"
    while get_cwidth(text) > columns and len(folder) > MIN_FOLDER:
        folder = folder[1:]
        text = f"{hint} | {CUT}{folder}"
    return fitted([("class:bar.quiet", text if get_cwidth(text) <= columns else hint)], columns)


def _joined(cells: Sequence[Line]) -> Line:
    line: Line = []
    for cell in cells:
        line += [SEPARATOR, *cell] if line else cell
    return line


def _style(process: Mapping[str, Any]) -> str:
    if process.get("paused"):
        return "class:bar.waiting"
    if process["state"] == "EXITED" and is_in_trouble(process):
        return "class:bar.trouble"
    return _STYLES.get(process["state"], "class:bar.quiet")


def _marks(process: Mapping[str, Any]) -> list[str]:
    marks = [] if process["state"] == "RUNNING" else [_state(process)]
    if process.get("restarts"):
        marks.append(f"x{process['restarts']}")
    if process.get("paused"):
        marks.append("paused")
    if process.get("muted"):
        marks.append("muted")
    return marks


def _state(process: Mapping[str, Any]) -> str:
    """The state in words: of one that has ended by itself, how."""
    state, end = process["state"], ending(process)
    if state == "EXITED" and end:
        return end
    word = str(state).lower()
    return f"{word} {end}" if state in ("BACKOFF", "FATAL") and end else word


def _cell(process: Mapping[str, Any], name: str, figures: Sequence[str] = ()) -> Line:
    words = "".join(f" {word}" for word in [*_marks(process), *figures])
    return [(_style(process), name), ("class:bar", words)]


def _figures(process: Mapping[str, Any]) -> list[str]:
    """CPU and memory, the more important one first."""
    figures = ((cpu, process.get("cpu_percent")), (memory, process.get("memory_bytes")))
    return [form(value) for form, value in figures if value is not None]


def _counted(processes: Sequence[Mapping[str, Any]], names: Mapping[str, str]) -> Iterator[Line]:
    """Counts, with names of processes in trouble: the longest form first."""
    states = Counter(_counted_as(p) for p in processes)
    counts = ", ".join(f"{count} {state}" for state, count in states.most_common())
    first: Line = [("class:bar", counts)]
    troubled = [p for p in processes if is_in_trouble(p)]
    cells = [_cell(p, names[p["name"]]) for p in troubled]
    used_cpu = sum(p.get("cpu_percent") or 0 for p in processes)
    used_memory = sum(p.get("memory_bytes") or 0 for p in processes)
    yield _joined([first, *cells, [("class:bar", f"{cpu(used_cpu)} {memory(used_memory)}")]])
    yield _joined([first, *cells, [("class:bar", cpu(used_cpu))]])
    yield _joined([first, *cells])
    for shown in range(len(troubled) - 1, 0, -1):
        some: list[Line] = [
            [(_style(p), middle_cut(names[p["name"]], LONG_NAME))] for p in troubled[:shown]
        ]
        yield _joined([first, *some, [("class:bar", f"+{len(troubled) - shown}")]])
    yield first


def _counted_as(process: Mapping[str, Any]) -> str:
    state = str(process["state"]).lower()
    if state != "exited":
        return state
    if is_in_trouble(process):
        return "failed"
    return "stopped" if (process.get("last_exit") or {}).get("asked") else "finished"
