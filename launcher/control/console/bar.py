"""The status bar: states of all processes in one line, in the longest form that fits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from prompt_toolkit.utils import get_cwidth

from launcher.base.text import count
from launcher.control.answer_lines import concern, readiness, unreachable
from launcher.control.console.short_forms import (
    cpu,
    end_cut,
    ending,
    has_died,
    is_in_trouble,
    memory,
    middle_cut,
)

Fragment = tuple[str, str]
Line = list[Fragment]

SEPARATOR = ("class:bar.quiet", " | ")
CUT = "..."
LONG_NAME, SHORT_NAME = 20, 12  # columns of names, before counts replace them
NAMED = 2  # names behind a filter; others are counted
HINT, SHORT_HINT = "help | F2 processes | Ctrl-C stops the run", "help | Ctrl-C stops the run"
SHOW = "`show` shows everything"
MAX_PATTERN = 30  # columns
MIN_FOLDER = 10  # characters; what is shorter is not shown
_STYLES = {
    "RUNNING": "class:bar.running",
    "STARTING": "class:bar.waiting",
    "BACKOFF": "class:bar.waiting",
    "STOPPING": "class:bar.waiting",
    "FATAL": "class:bar.trouble",
}


def status_lines(
    processes: Sequence[Mapping[str, Any]],
    folder: str,
    columns: int,
    *,
    hint: str,
    few: bool,
    page: str = "",
    faults: int = 0,
) -> list[Line]:
    """The status bar; `hint` explains the keys of what is open, `few` asks for a single line.

    `page` is the link of the page in the browser; `faults`, how many are active in a watched run.
    """
    first = _behind_faults(faults, processes, columns)
    filters = filter_line(processes, columns)
    if hint:
        keys = _with_page(fitted([("class:bar.waiting", hint)], columns), page, columns)
        if few:
            return [extended(keys, [filters], columns)] if filters else [keys]
        return [first, filters, keys] if filters else [first, keys]
    if not filters:
        if few:
            return [_with_page(first, page, columns)]
        return [first, folder_line(folder, columns, page)]
    if few:
        return [_with_page(extended(filters, [first], columns), page, columns)]
    ends: list[Line] = [[("class:bar.quiet", text)] for text in (SHOW, folder)]
    return [first, extended(_with_page(filters, page, columns), ends, columns)]


def _page_texts(link: str) -> list[str]:
    """The longest first; the shorter ones are without the token, and name the verb."""
    if not link:
        return []
    return [f"page: {link}", f"w opens {link.partition('/?')[0]}", "w opens the page"]


def _with_page(line: Line, link: str, columns: int) -> Line:
    """The line, with the longest form of the link that fits behind it."""
    longer = (_joined([line, [("class:bar.quiet", text)]]) for text in _page_texts(link))
    return next((one for one in longer if width(one) <= columns), line)


def status_line(processes: Sequence[Mapping[str, Any]], columns: int) -> Line:
    """Names with CPU and memory, with CPU, alone, short names, or counts: the first that fits.

    What processes wait for is part of the longer forms, `waiting` of all.
    """
    if not processes:
        return [("class:bar.quiet", "no processes")]
    names = short_names(processes)
    lines = [
        _joined([_cell(p, names[p["name"]], _figures(p)[:most], reason=True) for p in processes])
        for most in (2, 1, 0)
    ]
    lines += [
        _joined([_cell(p, middle_cut(names[p["name"]], most)) for p in processes])
        for most in (columns, LONG_NAME, SHORT_NAME)
    ]
    for line in [*lines, *_counted(processes, names)]:
        if width(line) <= columns:
            return line
    return fitted(line, columns)


def _behind_faults(faults: int, processes: Sequence[Mapping[str, Any]], columns: int) -> Line:
    """`status_line` behind `2 faults`, which is never left out."""
    if not faults:
        return status_line(processes, columns)
    mark: Line = [("class:bar.trouble", count(faults, "fault")), SEPARATOR]
    return fitted([*mark, *status_line(processes, max(0, columns - width(mark)))], columns)


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


def filter_line(processes: Sequence[Mapping[str, Any]], columns: int) -> Line:
    """What hides output: `level>=ERROR  grep 'Fleet'  solo monitor  hidden 812`; or nothing."""
    names = short_names(processes)
    texts: list[str] = []
    for key, form in (("level", "level>={}"), ("grep", "grep {!r}")):
        for value in dict.fromkeys(p[key] for p in processes if p.get(key)):
            those = [names[p["name"]] for p in processes if p.get(key) == value]
            cut = end_cut(str(value), MAX_PATTERN)
            texts.append(form.format(cut) + _listed(those if len(those) < len(processes) else ()))
    if any(p.get("hidden_by") == "solo" for p in processes):
        alone = [names[p["name"]] for p in processes if p.get("hidden_by") != "solo"]
        texts.append(f"solo{_listed(alone)}")
    muted = [names[p["name"]] for p in processes if _is_muted(p)]
    if muted:
        texts.append(f"mute{_listed(muted)}")
    if texts:
        texts.append(f"hidden {sum(p.get('hidden_lines') or 0 for p in processes)}")
    return fitted([("class:bar.waiting", "  ".join(texts))], columns) if texts else []


def _listed(names: Sequence[str]) -> str:
    more = [f"+{len(names) - NAMED}"] if len(names) > NAMED else []
    return "".join(f" {middle_cut(name, LONG_NAME)}" for name in [*names[:NAMED], *more])


def extended(line: Line, more: Sequence[Line], columns: int) -> Line:
    """The line, with as many of `more` behind it as fit, each on its own."""
    for part in more:
        longer = _joined([line, part])
        if width(longer) <= columns:
            line = longer
    return line


def folder_line(folder: str, columns: int, page: str = "") -> Line:
    """A hint for newcomers, the page and the log folder, whose end says most."""
    hints = [f"{one} | {text}" for text in _page_texts(page) for one in (HINT, SHORT_HINT)]
    fitting = (one for one in (*hints, HINT) if get_cwidth(one) <= columns)
    hint = next(fitting, SHORT_HINT)
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
    if process.get("paused") or concern(process) or process.get("lacks"):
        return "class:bar.waiting"
    if has_died(process):
        return "class:bar.trouble"
    return _STYLES.get(process["state"], "class:bar.quiet")


def _marks(process: Mapping[str, Any], *, reason: bool = False) -> list[str]:
    """`reason`: with what it waits for, or lacks to be ready."""
    is_waiting, is_unready = bool(process.get("waiting_for")), bool(process.get("lacks"))
    if reason and (is_waiting or is_unready):
        marks = [readiness(process)]
    elif is_waiting or is_unready:
        marks = ["waiting" if is_waiting else "not ready"]
    else:
        marks = [] if process["state"] == "RUNNING" else [_state(process)]
    marks += filter(None, [concern(process)])
    if process.get("restarts"):
        marks.append(f"x{process['restarts']}")
    if process.get("paused"):
        marks.append("paused")
    if _is_muted(process):
        marks.append("muted")  # `solo` is in the line of the filters
    return marks


def _is_muted(process: Mapping[str, Any]) -> bool:
    """Whether by its name, even if a `solo` of others hides it as well."""
    if process.get("muted_by_name"):
        return True
    return bool(process.get("muted")) and process.get("hidden_by") != "solo"


def _state(process: Mapping[str, Any]) -> str:
    """The state in words: of one that has ended by itself, how."""
    state, end = process["state"], ending(process)
    if (state == "EXITED" and end) or has_died(process):
        return end
    word = str(state).lower()
    return f"{word} {end}" if state in ("BACKOFF", "FATAL") and end else word


def _cell(
    process: Mapping[str, Any], name: str, figures: Sequence[str] = (), *, reason: bool = False
) -> Line:
    words = "".join(f" {word}" for word in [*_marks(process, reason=reason), *figures])
    return [(_style(process), name), ("class:bar", words)]


def _figures(process: Mapping[str, Any]) -> list[str]:
    """CPU and memory, the more important one first."""
    figures = ((cpu, process.get("cpu_percent")), (memory, process.get("uss_bytes")))
    return [form(value) for form, value in figures if value is not None]


def _counted(processes: Sequence[Mapping[str, Any]], names: Mapping[str, str]) -> Iterator[Line]:
    """Counts, with names of processes in trouble: the longest form first."""
    states = Counter(_counted_as(p) for p in processes)
    counts = ", ".join(f"{number} {state}" for state, number in states.most_common())
    first: Line = [("class:bar", counts)]
    troubled = [p for p in processes if is_in_trouble(p)]
    cells = [_cell(p, names[p["name"]]) for p in troubled]
    used_cpu = sum(p.get("cpu_percent") or 0 for p in processes)
    used_memory = sum(p.get("uss_bytes") or 0 for p in processes)
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
    if unreachable(process):
        return "unreachable"
    if process.get("waiting_for"):
        return "waiting"
    if process.get("not_responding_s"):
        return "not responding"
    if has_died(process):
        return "failed"
    if state != "exited":
        return state
    return "stopped" if (process.get("last_exit") or {}).get("asked") else "finished"
