"""Failure: what was expected, what was seen, and what may help, in some lines."""

from __future__ import annotations

from launcher.smoke.expect.quantities import printable, seconds_text
from launcher.smoke.observe.facts import Facts
from launcher.smoke.reports.result import Judged

LINES = 10
PROCESSES = 3  # whose last lines are shown: one cause has many victims
_WIDTH = 200


def describe(one: Judged, facts: Facts, told: dict[str, str] | None = None) -> list[str]:
    """The lines about an expectation that is not met.

    `told`: processes whose last lines stand above already, under the name of what expectation.
    """
    verdict, expectation = one.verdict, one.expectation
    lines = [
        f"{expectation.name}    ({expectation.origin})",
        f"    expected: {verdict.expected}",
        f"    seen:     {verdict.seen or 'nothing'}",
    ]
    if verdict.at_s is not None:
        lines.append(f"    since:    {seconds_text(max(0.0, verdict.at_s))} after the start")
    if verdict.guess:
        lines.append(f"    maybe:    {verdict.guess}")
    for process in verdict.about[:PROCESSES]:
        if told is not None and process in told:
            lines.append(f"    last lines of {process}: above, under '{told[process]}'")
            continue
        lines += _last_lines(process, facts)
        if told is not None:
            told[process] = expectation.name
    return [printable(line) for line in lines]


def _last_lines(process: str, facts: Facts) -> list[str]:
    last = facts.last_lines(process, LINES)
    if not last:
        return [f"    {process} printed nothing"]
    shown = [f"        [{line.at_s:6.1f} s] {_short(line.plain)}" for line in last]
    return [f"    last lines of {process}:", *shown]


def _short(text: str) -> str:
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 3]}..."
