"""Judges of printed lines: a line, the order of lines, errors and tracebacks."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from launcher.base.document.quantities import INFINITY, NumberRange
from launcher.smoke.expect.expectation import STOP, Expectation, Verdict
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import (
    Window,
    shorten,
    times_text,
    with_window,
)
from launcher.smoke.observe.facts import Facts, LogLine

_TRACEBACK = "Traceback (most recent call last):"
_OF_A_STOP = re.compile(r"^(?:\w+\.)*(KeyboardInterrupt|ExternalShutdownException)\b")
_AT_LEAST_ONE = NumberRange(low=1, high=INFINITY, text=">= 1")


# ---- lines


def _log_text(expectation: Expectation) -> str:
    count: NumberRange | None = expectation.get("count")
    number = "a line" if count is None else f"{count.text} lines"
    level = f" of level {expectation.get('level')}" if expectation.get("level") else ""
    process = f" from {expectation.get('process')}" if expectation.get("process") else ""
    pattern = expectation.subject.pattern
    return f"{number}{level}{process} with '{pattern}'{times_text(expectation)}"


@with_window(_log_text)
def log(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    span: NumberRange = expectation.get("count") or _AT_LEAST_ONE
    level, process = expectation.get("level"), expectation.get("process")
    same = [
        line
        for line in facts.lines
        if expectation.subject.search(line.plain) and facts.is_from(line, process)
    ]
    lines = [line for line in same if level in (None, line.level)]
    early = next((line for line in lines if when.is_too_early(line.at_s)), None)
    if early is not None:
        seen = f"too early, after {when.since(early.at_s)}: {_quoted(early)}"
        return when.violated(seen=seen, at_s=early.at_s)
    found = [line for line in lines if line.at_s in when]
    if len(found) > span.high:
        extra = found[int(span.high)]
        seen = f"{len(found)}; one too many after {when.since(extra.at_s)}: {_quoted(extra)}"
        about = (extra.process,) if extra.process else ()
        return when.violated(seen=seen, at_s=extra.at_s, value=len(found), about=about)
    if when.is_enough(len(found), span):
        return when.met(**_seen(found, span, when))
    return when.not_yet(
        seen=f"{len(found)}" if found else _nearest(same, lines, facts, process, when),
        guess=explain.missing_line(expectation.subject, process, level, when.start_s, facts)
        if when.closed
        else None,
        about=_abouts(expectation, facts),
        value=len(found),
    )


def _seen(found: Sequence[LogLine], span: NumberRange, when: Window) -> dict[str, object]:
    if not found:
        return {"seen": "no such line", "value": 0.0}
    line = found[max(0, min(int(span.low), len(found)) - 1)]
    number = "" if len(found) == 1 else f"{len(found)} lines, "
    seen = f"{number}after {when.since(line.at_s)}: {_quoted(line)}"
    return {"seen": seen, "at_s": line.at_s, "value": line.at_s - when.start_s, "unit": "s"}


def _nearest(
    same: Sequence[LogLine],
    lines: Sequence[LogLine],
    facts: Facts,
    process: str | None,
    when: Window,
) -> str:
    """What was printed instead: `lines` at another time, `same` with another level."""
    if lines:
        last = lines[-1]
        if last.at_s > when.to_s:
            return f"too late, after {when.since(last.at_s)}: {_quoted(last)}"
        return f"only before, at {last.at_s:.1f} s of the run: {_quoted(last)}"
    if same:
        return f"no such line; one of level {same[-1].level}: {_quoted(same[-1])}"
    return f"no such line among {sum(facts.is_from(line, process) for line in facts.lines)}"


def _abouts(expectation: Expectation, facts: Facts) -> tuple[str, ...]:
    pattern = expectation.get("process")
    return () if pattern is None else facts.named(pattern)[:2]


def _quoted(line: LogLine) -> str:
    process = f"[{line.process}] " if line.process else ""
    return f"{process}{shorten(line.plain)}"


# ---- order


def _order_text(expectation: Expectation) -> str:
    patterns = ", then ".join(f"'{p.pattern}'" for p in expectation.subject)
    process = f" from {expectation.get('process')}" if expectation.get("process") else ""
    return f"first lines{process} in this order: {patterns}{times_text(expectation)}"


@with_window(_order_text)
def order(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    lines = [
        line
        for line in facts.lines
        if line.at_s in when and facts.is_from(line, expectation.get("process"))
    ]
    before, earlier = 0, ""
    for pattern in expectation.subject:
        index = next((i for i, line in enumerate(lines) if pattern.search(line.plain)), None)
        if index is None:
            seen = f"no line with '{pattern.pattern}'"
            return when.not_yet(seen=seen, about=_abouts(expectation, facts))
        if index < before:
            seen = f"'{pattern.pattern}' came before '{earlier}': {_quoted(lines[index])}"
            return when.violated(seen=seen, at_s=lines[index].at_s)
        before, earlier = index, pattern.pattern
    return when.met(seen="in this order")


# ---- errors


def _whom(expectation: Expectation) -> str:
    return "any process" if expectation.subject == "*" else str(expectation.subject)


def _of_subject(expectation: Expectation, facts: Facts) -> Iterator[LogLine]:
    """`*` includes the lines of the launcher."""
    pattern = expectation.subject
    for line in facts.lines:
        if pattern == "*" or (line.process and facts.is_named(line.process, pattern)):
            yield line


@with_window(lambda e: f"no line of level ERROR or FATAL from {_whom(e)}{times_text(e)}")
def no_errors(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    excepted = expectation.get("except", ())
    bad = [
        line
        for line in _of_subject(expectation, facts)
        if line.at_s in when
        and line.level in ("ERROR", "FATAL")
        and not any(pattern.search(line.plain) for pattern in excepted)
    ]
    return _none_of(bad, when)


def _none_of(bad: Sequence[LogLine], when: Window) -> Verdict:
    if not bad:
        return when.so_far(seen="none", value=0.0)
    first = bad[0]
    number = "" if len(bad) == 1 else f"{len(bad)}, the first "
    return when.violated(
        seen=f"{number}after {when.since(first.at_s)}: {_quoted(first)}",
        at_s=first.at_s,
        value=len(bad),
        about=(first.process,) if first.process else (),
    )


@with_window(lambda e: f"no traceback from {_whom(e)}{times_text(e)}")
def no_tracebacks(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    lines = list(_of_subject(expectation, facts))
    stopped_s = facts.steps.get(STOP, INFINITY)
    bad = []
    for index, line in enumerate(lines):
        if _TRACEBACK not in line.plain or line.at_s not in when:
            continue
        last = _last_line(lines, index)
        if not (line.at_s >= stopped_s and last and _OF_A_STOP.match(last.plain)):
            bad.append(last or line)
    return _none_of(bad, when)


def _last_line(lines: Sequence[LogLine], index: int) -> LogLine | None:
    """The line with the exception: the first one of the process that is not indented."""
    following = (lines[number] for number in range(index + 1, len(lines)))
    same = (line for line in following if line.process == lines[index].process)
    return next((line for line in same if line.plain[:1] not in ("", " ")), None)
