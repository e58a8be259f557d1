"""Tells the page of a run that smoke watches which expectations are decided.

The server of the page (`launcher/web`) reads the file in the log folder of the run.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from launcher.base import strict_json
from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.observe.recorder import FactRecorder
from launcher.smoke.reports.moments import item, moment_s

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
