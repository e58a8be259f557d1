"""The lines of the log around an incident: levels coloured, lines of evidence marked."""

from __future__ import annotations

import re
from collections.abc import Sequence

from launcher.base.text import count
from launcher.faults.incident.document import IncidentDocument, ReportedLine
from launcher.faults.incident.limits import PageLimits, clipped
from launcher.faults.incident.markup import EMPTY, Markup, details, join, plain, section, tag
from launcher.faults.incident.parts.span import clock, offset
from launcher.output.filters import ERROR, LEVELS, LineLevels

NEAR = 120  # lines that are shown without a click
MAX_CHARACTERS = 2000  # of a line
MAX_BYTES = 700_000  # of all lines together
_OF_PROCESS = re.compile(r"^\[[^\]]+-\d+\] ")
_WARN = LEVELS.index("WARN")
_STYLES = ("debug", "info", "warn", "error", "error")


def log(incident: IncidentDocument, limits: PageLimits) -> Markup:
    lines = sorted(incident.lines, key=lambda one: one.wall_s)
    if not lines:
        return EMPTY
    at = _opening(lines, incident.opened_s)
    first, last = _fitting(lines, at, limits.of(MAX_BYTES))
    left_out = len(lines) - (last - first)
    rows = _rows(lines, first, last, incident)
    near = slice(max(0, at - first - NEAR * 2 // 3), at - first + NEAR // 3)
    before, shown, after = rows[: near.start], rows[near], rows[near.stop :]
    split = min(at - first - near.start, len(shown))
    around = [_list(shown[:split]), tag("p", "the incident opens", class_="opens")]
    around.append(_list(shown[split:]))
    note = f"{count(left_out, 'line')} further away are left out." if left_out else EMPTY
    filter_box = tag("input", type="checkbox", id="only-problems")
    return section(
        "log",
        "Log",
        filter_box,
        tag("label", "Only warnings, errors and evidence", for_="only-problems"),
        tag("div", _part(before, "earlier"), *around, _part(after, "later"), class_="log"),
        tag("p", note, class_="muted small") if note else EMPTY,
    )


def _opening(lines: Sequence[ReportedLine], opened_s: float) -> int:
    """The number of the first line after the opening."""
    return next((n for n, one in enumerate(lines) if one.wall_s > opened_s), len(lines))


def _fitting(lines: Sequence[ReportedLine], at: int, room: int) -> tuple[int, int]:
    """The part of the lines around `at` that has about so many bytes."""
    first = last = at
    while first > 0 or last < len(lines):
        takes_before = first > 0 and (last == len(lines) or at - first <= 2 * (last - at))
        one = lines[first - 1] if takes_before else lines[last]
        room -= min(len(one.text), MAX_CHARACTERS) * 2 + 200  # with its element
        if room < 0:
            break
        first, last = (first - 1, last) if takes_before else (first, last + 1)
    return first, last


def _rows(
    lines: Sequence[ReportedLine], first: int, last: int, incident: IncidentDocument
) -> list[Markup]:
    levels = LineLevels()
    evidence = {plain(text).strip() for fault in incident.faults for text in fault.lines} - {""}
    evidence |= {_OF_PROCESS.sub("", text) for text in evidence}
    rows = []
    for line in lines[first:last]:
        text = plain(clipped(line.text, MAX_CHARACTERS), keep="\t")
        level = levels.of(line.process, text.encode(errors="replace"))
        rows.append(
            _row(line, text, level, incident.opened_s, is_evidence=text.strip() in evidence)
        )
    return rows


def _row(line: ReportedLine, text: str, level: int, zero_s: float, *, is_evidence: bool) -> Markup:
    style = _STYLES[min(level, ERROR)]
    dull = " dull" if level < _WARN and not is_evidence else ""
    at = offset(line.wall_s, zero_s) if line.wall_s else ""
    when = tag("span", at, class_="offset", title=clock(line.wall_s) if line.wall_s else None)
    shown = tag("mark", text) if is_evidence else text
    who = tag("span", line.process or "launcher", class_="who")
    return tag("li", when, who, tag("span", shown, class_="said"), class_=style + dull)


def _list(rows: Sequence[Markup]) -> Markup:
    return tag("ol", join(rows)) if rows else EMPTY


def _part(rows: Sequence[Markup], side: str) -> Markup:
    return details(f"{count(len(rows), 'line')} {side}", _list(rows)) if rows else EMPTY
