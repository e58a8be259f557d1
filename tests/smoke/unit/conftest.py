"""Conditions are evaluated without a process of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from launcher.smoke.expect.evaluation import EvaluatedCondition, judged
from launcher.smoke.judges import common


class InProcess:
    """An evaluator without limits."""

    def judged(
        self,
        conditions: Sequence[EvaluatedCondition],
        contents: Sequence[Any],
        patience_s: float | None = None,
    ) -> list[tuple[bool, str | None]]:
        return [judged(conditions, content) for content in contents]


@pytest.fixture(autouse=True)
def _evaluator(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(common, "EVALUATOR", InProcess())
