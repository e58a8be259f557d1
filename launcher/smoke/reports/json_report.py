"""The content of `report.json`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from launcher.smoke.reports import measures
from launcher.smoke.reports.result import Judged, SmokeResult

VERSION = 1


def of_result(result: SmokeResult) -> dict[str, Any]:
    facts = result.facts
    ending = facts.ending
    return {
        "version": VERSION,
        "words": list(result.words),
        "exit_code": int(result.exit_code),
        "trouble": result.trouble,
        "gave_up": result.gave_up,
        "domain_id": result.domain_id,
        "ready_s": _rounded(facts.ready_s),
        "seconds": _rounded(facts.now_s),
        "steps": {name: _rounded(at_s) for name, at_s in facts.steps.items()},
        "expectations": [_judged(one) for one in result.judged],
        "measures": measures.to_document(measures.of_result(result)),
        "ending": None if ending is None else asdict(ending),
        "troubles": list(facts.troubles),
    }


def _judged(one: Judged) -> dict[str, Any]:
    expectation, verdict = one.expectation, one.verdict
    return {
        "name": expectation.name,
        "kind": expectation.kind,
        "outcome": verdict.outcome.value,
        "expected": verdict.expected,
        "seen": verdict.seen,
        "at_s": _rounded(verdict.at_s),
        "value": _rounded(verdict.value),
        "unit": verdict.unit,
        "guess": verdict.guess,
        "implicit": expectation.implicit,
        "file": expectation.origin.text,
        "line": expectation.origin.line or None,
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
