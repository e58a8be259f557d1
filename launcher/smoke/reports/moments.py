"""Expectations with the moment at which each was decided, for the page in the browser."""

from __future__ import annotations

from typing import Any

from launcher.smoke.expect.expectation import Decision, Expectation, Verdict

_STATES = {Decision.MET: "passed", Decision.VIOLATED: "failed", Decision.OPEN: "open"}


def item(expectation: Expectation, verdict: Verdict | None, wall_s: float | None) -> dict[str, Any]:
    """An entry of the message `expectations`; without a verdict it is open."""
    return {
        "title": expectation.name,
        "state": "open" if verdict is None else _STATES[verdict.outcome],
        "wall": wall_s,
        "detail": "" if verdict is None else sentence(verdict),
    }


def moment_s(verdict: Verdict, decided_s: float, *, is_end: bool = False) -> float:
    """When it came true, or failed; `is_end`: what holds until the end is true then."""
    if verdict.at_s is None or (is_end and verdict.outcome is Decision.MET):
        return decided_s
    return verdict.at_s


def sentence(verdict: Verdict) -> str:
    """What was seen; of a failure what was expected as well."""
    if verdict.outcome is Decision.MET:
        return verdict.seen or verdict.expected
    guess = f"; maybe: {verdict.guess}" if verdict.guess else ""
    return f"expected: {verdict.expected}; seen: {verdict.seen or 'nothing'}{guess}"
