"""Judges of what processes print: lines, their order, errors and tracebacks."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from launcher.smoke.expect.expectation import Expectation, Outcome, Period, Verdict, times_text
from launcher.smoke.expect.quantities import Span
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import met, not_yet, violated, with_period
from launcher.smoke.observe.facts import STOP, Facts, LogLine

LAUNCHER = "launch"  # the process that stands for the launcher itself
_TRACEBACK = "Traceback (most recent call last):"
_OF_A_STOP = re.compile(r"^(?:\w+\.)*(KeyboardInterrupt|ExternalShutdownException)\b")
_AT_LEAST_ONE = Span(low=1, high=float("inf"), text=">= 1")


def _is_of(expectation: Expectation, line: LogLine, facts: Facts) -> bool:
    """The launcher's own lines have to be asked for: they repeat those of others."""
    pattern = expectation.get("process", "*")
    if line.process is None:
        return bool(pattern == LAUNCHER)
    return facts.is_named(line.process, pattern)


def matching(expectation: Expectation, facts: Facts) -> list[LogLine]:
    """The lines that the expectation means, whenever they came."""
    pattern, level = expectation.subject, expectation.get("level")
    return [
        line
        for line in facts.lines
        if pattern.search(line.plain)
        and (level is None or line.level == level)
        and _is_of(expectation, line, facts)
    ]


# ---- lines


def _log_text(expectation: Expectation) -> str:
    count: Span | None = expectation.get("count")
    number = "a line" if count is None else f"{count.text} lines"
    level = f" of level {expectation.get('level')}" if expectation.get("level") else ""
    process = f" from {expectation.get('process')}" if expectation.get("process") else ""
    pattern = expectation.subject.pattern
    return f"{number}{level}{process} with '{pattern}'{times_text(expectation)}"


def _log(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    span: Span = expectation.get("count") or _AT_LEAST_ONE
    lines = matching(expectation, facts)
    early = next((line for line in lines if when.is_too_early(line.at_s)), None)
    if early is not None:
        seen = f"too early, after {when.since(early.at_s)}: {_quoted(early)}"
        return violated(expected, seen=seen, at_s=early.at_s)
    found = [line for line in lines if line.at_s in when]
    if len(found) > span.high:
        extra = found[int(span.high)]
        seen = f"{len(found)}; one too many after {when.since(extra.at_s)}: {_quoted(extra)}"
        about = (extra.process,) if extra.process else ()
        return violated(expected, seen=seen, at_s=extra.at_s, value=len(found), about=about)
    if len(found) >= span.low and (span.high == float("inf") or when.closed):
        return met(expected, **_seen(found, span, when))
    return not_yet(
        when,
        expected,
        seen=_nearest(expectation, facts, lines, len(found), when),
        guess=_guess(expectation, facts, when) if when.closed else None,
        about=_abouts(expectation, facts),
        value=len(found),
    )


def _guess(expectation: Expectation, facts: Facts, when: Period) -> str | None:
    process, level = expectation.get("process"), expectation.get("level")
    return explain.line(expectation.subject, process, level, when.start_s, facts)


def _seen(found: Sequence[LogLine], span: Span, when: Period) -> dict[str, object]:
    if not found:
        return {"seen": "no such line", "value": 0.0}
    line = found[max(0, min(int(span.low), len(found)) - 1)]
    number = "" if len(found) == 1 else f"{len(found)} lines, "
    seen = f"{number}after {when.since(line.at_s)}: {_quoted(line)}"
    return {"seen": seen, "at_s": line.at_s, "value": line.at_s - when.start_s, "unit": "s"}


def _nearest(
    expectation: Expectation, facts: Facts, lines: Sequence[LogLine], count: int, when: Period
) -> str:
    if lines and not count:
        last = lines[-1]
        if last.at_s > when.to_s:
            return f"too late, after {when.since(last.at_s)}: {_quoted(last)}"
        return f"only before, at {last.at_s:.1f} s of the run: {_quoted(last)}"
    if count:
        return f"{count}"
    of = [line for line in facts.lines if _is_of(expectation, line, facts)]
    same = [line for line in of if expectation.subject.search(line.plain)]
    if same:
        return f"no such line; one of level {same[-1].level}: {_quoted(same[-1])}"
    return f"no such line among {len(of)}"


def _abouts(expectation: Expectation, facts: Facts) -> tuple[str, ...]:
    pattern = expectation.get("process")
    return () if pattern is None else facts.named(pattern)[:2]


def _quoted(line: LogLine) -> str:
    process = f"[{line.process}] " if line.process else ""
    text = line.plain if len(line.plain) <= 200 else f"{line.plain[:197]}..."
    return f"{process}{text}"


# ---- order


def _order_text(expectation: Expectation) -> str:
    patterns = ", then ".join(f"'{p.pattern}'" for p in expectation.subject)
    process = f" from {expectation.get('process')}" if expectation.get("process") else ""
    return f"first lines{process} in this order: {patterns}{times_text(expectation)}"


def _order(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    lines = [line for line in facts.lines if line.at_s in when and _is_of(expectation, line, facts)]
    before: tuple[int, str] | None = None
    for pattern in expectation.subject:
        index = next((i for i, line in enumerate(lines) if pattern.search(line.plain)), None)
        if index is None:
            seen = f"no line with '{pattern.pattern}'"
            return not_yet(when, expected, seen=seen, about=_abouts(expectation, facts))
        if before is not None and index < before[0]:
            seen = f"'{pattern.pattern}' came before '{before[1]}': {_quoted(lines[index])}"
            return violated(expected, seen=seen, at_s=lines[index].at_s)
        before = (index, pattern.pattern)
    return met(expected, seen="in this order")


# ---- errors


def _no_errors_text(expectation: Expectation) -> str:
    return f"no line of level ERROR or FATAL from {_whom(expectation)}{times_text(expectation)}"


def _whom(expectation: Expectation) -> str:
    return "anything" if expectation.subject == "*" else str(expectation.subject)


def _of_subject(expectation: Expectation, facts: Facts) -> Iterator[LogLine]:
    for line in facts.lines:
        if line.process is None:
            if expectation.subject == "*":
                yield line
        elif facts.is_named(line.process, expectation.subject):
            yield line


def _no_errors(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    excepted = expectation.get("except", ())
    bad = [
        line
        for line in _of_subject(expectation, facts)
        if line.at_s in when
        and line.level in ("ERROR", "FATAL")
        and not any(pattern.search(line.plain) for pattern in excepted)
    ]
    return _none_of(bad, when, expected)


def _none_of(bad: Sequence[LogLine], when: Period, expected: str) -> Verdict:
    if not bad:
        outcome = Outcome.MET if when.closed else Outcome.OPEN
        return Verdict(outcome=outcome, expected=expected, seen="none", value=0.0)
    first = bad[0]
    number = "" if len(bad) == 1 else f"{len(bad)}, the first "
    return violated(
        expected,
        seen=f"{number}after {when.since(first.at_s)}: {_quoted(first)}",
        at_s=first.at_s,
        value=len(bad),
        about=(first.process,) if first.process else (),
    )


def _no_tracebacks_text(expectation: Expectation) -> str:
    return f"no traceback from {_whom(expectation)}{times_text(expectation)}"


def _no_tracebacks(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    lines = list(_of_subject(expectation, facts))
    stopped_s = facts.steps.get(STOP, float("inf"))
    bad = []
    for index, line in enumerate(lines):
        if _TRACEBACK not in line.plain or line.at_s not in when:
            continue
        last = _last_line(lines, index)
        if not (line.at_s >= stopped_s and last and _OF_A_STOP.match(last.plain)):
            bad.append(last or line)
    return _none_of(bad, when, expected)


def _last_line(lines: Sequence[LogLine], index: int) -> LogLine | None:
    """The line that names the exception: the first of the process that is not indented."""
    following = (lines[number] for number in range(index + 1, len(lines)))
    same = (line for line in following if line.process == lines[index].process)
    return next((line for line in same if line.plain[:1] not in ("", " ")), None)


log = with_period(_log, _log_text)
order = with_period(_order, _order_text)
no_errors = with_period(_no_errors, _no_errors_text)
no_tracebacks = with_period(_no_tracebacks, _no_tracebacks_text)
