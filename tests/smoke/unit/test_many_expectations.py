"""Thousands of expectations are loaded, judged and shown in linear time."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import LogLine
from launcher.smoke.preflight import loader
from launcher.smoke.reports import text_report
from launcher.smoke.reports.result import Judged, SmokeResult
from tests.smoke.unit.facts import seen

FEW, MANY = 150, 3000
ROOM = 6  # what grows with the number takes twenty times as long, with its square 400 times


def written(count: int) -> str:
    steps = "".join(f"  - {{do: kill a, name: s{n}}}\n" for n in range(count // 10))
    entries = "".join(f"  - node: /n{n}\n    name: e{n}\n    after: s1\n" for n in range(count))
    return f"scenario:\n{steps}expect:\n{entries}"


def cpu_s(work: Callable[[], object]) -> float:
    began_s = time.process_time()
    work()
    return time.process_time() - began_s


@pytest.mark.thorough
def test_the_time_to_read_a_file_grows_with_its_length():
    small, large = written(FEW), written(MANY)
    few_s = min(cpu_s(lambda: loader.parse(small, "x.yaml")) for _ in range(3))
    many_s = min(cpu_s(lambda: loader.parse(large, "x.yaml")) for _ in range(2))
    assert many_s < ROOM * few_s * MANY / FEW


def test_lines_are_in_order_of_time_whenever_they_are_asked_for():
    recorder = FactRecorder()
    for at_s in (2.0, 1.0):
        recorder.add(LogLine(at_s=at_s, process="a-1", text="x"))
    assert [line.at_s for line in recorder.facts().lines] == [1.0, 2.0]
    assert recorder.facts().lines is recorder.facts().lines  # not sorted again and again
    recorder.add(LogLine(at_s=0.0, process="a-1", text="x"))
    assert [line.at_s for line in recorder.facts().lines] == [0.0, 1.0, 2.0]


def judged(name: str, outcome: Decision) -> Judged:
    expectation = Expectation(kind="node", subject=f"/{name}", name=name)
    return Judged(expectation=expectation, verdict=Verdict(outcome=outcome, expected="it is there"))


def shown(*found: Judged) -> str:
    stream = io.StringIO()
    result = SmokeResult(judged=found, facts=seen(), folder=Path(), words=(), domain_id=1)
    text_report.show(text_report.console_for(stream, colour=False), result)
    return stream.getvalue()


def test_of_many_expectations_those_are_shown_that_are_not_met():
    good = [judged(f"good{n}", Decision.MET) for n in range(text_report.ROWS)]
    assert "good0" in shown(*good)
    text = shown(*good, judged("bad", Decision.VIOLATED))
    assert "NOT MET   bad" in text
    assert "good" not in text
    assert f"... and {text_report.ROWS} met" in text
    assert f"smoke: {text_report.ROWS} of {text_report.ROWS + 1} expectations met" in text
