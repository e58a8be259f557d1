"""Expectations with the moment at which each was decided, for the page in the browser.

The server of the page (`launcher/web`) reads the file of those of a run in its log folder.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.observe.fact_recorder import FactRecorder

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


FILE = "expectations.json"


class LiveExpectations:
    """Writes the file as a whole, whenever one more is decided."""

    def __init__(self, folder: Path, recorder: FactRecorder) -> None:
        self._path = folder / FILE
        self._recorder = recorder
        self._written: int | None = None

    def write(
        self, expectations: Sequence[Expectation], decided: Mapping[str, tuple[Verdict, float]]
    ) -> None:
        """`decided`: verdicts by the names of expectations, with the time of the run."""
        if len(decided) == self._written:
            return
        self._written = len(decided)
        items = []
        for one in expectations:
            verdict, at_s = decided.get(one.name, (None, 0.0))
            wall_s = None
            if verdict is not None:
                wall_s = self._recorder.wall_of(moment_s(verdict, at_s))
            items.append(item(one, verdict, wall_s))
        beside = self._path.with_suffix(".new")
        with contextlib.suppress(OSError):  # nobody may be looking
            beside.write_text(strict_json.dumps({"items": items}), encoding="utf-8")
            os.replace(beside, self._path)
