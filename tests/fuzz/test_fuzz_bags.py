"""Mutated bags through all verbs of `bag`: an exit code and one sentence, within time and memory.

`make fuzz` does the same with more bags, and prints how each verb ended.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.bags import worker
from tests.fuzz.bags.campaign import Result, run
from tests.fuzz.bags.seeds import KINDS


def check(result: Result, bags: int) -> None:
    assert not result.problems, "\n".join(result.problems)
    assert result.cases == bags
    assert result.codes.total() == bags * len(worker.VERBS)
    assert {code for _, _, code in result.codes} == {0, 1}


def test_few_mutated_bags():
    check(run(KINDS, range(1)), len(KINDS))


def test_what_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    assert worker.run(("info", str(tmp_path)))["problem"] == ""
    assert "exit code 2" in worker.run(("nonsense",))["problem"]
    monkeypatch.setattr(worker, "main", lambda words: {}["x"])
    assert "KeyError: 'x'" in worker.run(("info",))["problem"]
    monkeypatch.setattr(worker, "main", lambda words: 1)
    assert worker.run(("info",))["problem"] == "no word"
