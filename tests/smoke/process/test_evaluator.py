"""Conditions that cost too much: the process that evaluates them is bounded, and leaves nothing."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator

import psutil
import pytest

from launcher.smoke.expect.evaluator import (
    EvaluatedCondition,
    Evaluator,
    NotYetError,
    TooExpensiveError,
)
from launcher.smoke.expect.message_conditions import Conditions, Expression
from tests.smoke.process.bench import PATIENT, Bench
from tests.support.children import children_with
from tests.support.waiting import wait_until

MODULE = "launcher.smoke.expect.evaluation"
ENDLESS = "9**9**9 > 0"


@pytest.fixture
def evaluator() -> Iterator[Evaluator]:
    one = Evaluator()
    yield one
    one.close()


def helpers(pid: int) -> list[psutil.Process]:
    return children_with(pid, MODULE)


@pytest.mark.parametrize(
    ("condition", "limit"),
    [
        (Expression.parse(ENDLESS), "1 s of CPU time"),
        (Expression.parse("[0] * 10**10"), "512 MB of memory"),
        (Expression.parse("'x' * 10**10"), "512 MB of memory"),
        (Expression.parse("1 << 10**12"), "512 MB of memory"),
        pytest.param(
            Expression.parse("sum(i for i in range(10**10))"),
            "1 s of CPU time",
            marks=pytest.mark.thorough,
        ),
        pytest.param(
            Conditions.parse({"a": {"matches": "(a+)+$"}}),
            "1 s of CPU time",
            marks=pytest.mark.thorough,
        ),
    ],
    ids=lambda one: getattr(one, "text", None),
)
def test_a_limit_is_named_and_others_are_evaluated(
    evaluator: Evaluator, condition: EvaluatedCondition, limit: str
):
    content = {"a": "a" * 40 + "!"}
    for _ in range(2):  # the second time at once
        with pytest.raises(TooExpensiveError) as caught:
            evaluator.judged([condition], [content])
        assert str(caught.value) == f"the evaluation of '{condition.text}' takes more than {limit}"
    assert evaluator.judged([Expression.parse("m.a[0] == 'a'")], [content]) == [(True, None)]


def test_one_process_judges_each_content_once(evaluator: Evaluator):
    wanted = Expression.parse("m.n > 1")
    contents = [{"n": number} for number in range(4)]
    found = [evaluator.judged([wanted], contents[:count]) for count in (2, 4)]
    assert [[fits for fits, _ in one] for one in found] == [[False] * 2, [False, False, True, True]]
    contents[3]["n"] = 0  # known, so not asked again
    assert evaluator.judged([wanted], contents[3:]) == [(True, None)]


@pytest.mark.thorough
def test_one_who_cannot_wait_asks_again(evaluator: Evaluator):
    wanted, content = Expression.parse(ENDLESS), {"n": 1}
    with pytest.raises(NotYetError):
        evaluator.judged([wanted], [content], 0.0)
    with pytest.raises(TooExpensiveError):
        evaluator.judged([wanted], [content])


# What the parent does while the process is in the middle of arithmetic.
_PARENT = f"""
import threading
from launcher.smoke.expect.message_conditions import Expression
from launcher.smoke.expect.evaluator import EVALUATOR
EVALUATOR.judged([Expression.parse("m")], [1])
print("ready", flush=True)
EVALUATOR.judged([Expression.parse("{ENDLESS}")], [1])
"""


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGKILL])
def test_the_process_ends_with_its_parent(signum: signal.Signals):
    parent = subprocess.Popen(
        [sys.executable, "-c", _PARENT], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert parent.stdout is not None
    assert parent.stdout.readline() == b"ready\n"
    (helper,) = helpers(parent.pid)
    parent.send_signal(signum)
    assert parent.wait(60) in (-signum, 1)
    wait_until(lambda: not helper.is_running() or helper.status() == "zombie", "the helper ends")


@pytest.mark.thorough
def test_expensive_expectations_fail_and_others_are_judged(bench: Bench):
    bench.write(PATIENT, f"""sh("dull", "echo {"a" * 40}!; exec sleep 1000"),""")
    bench.expect(
        """
        scenario:
          - {after_log: '(a+)+$', process: dull, do: kill patient, name: never}
        expect:
          - {name: slow line, log: '(a+)+$', process: dull}
          - {name: slow order, order: ['(a+)+$', b], process: dull}
          - {name: other, log: here I am, process: patient, within: 60 s}
        """
    )
    done = bench.smoke("--for=1")
    assert done.returncode == 3, done.stdout + done.stderr
    assert bench.outcomes()["other"] == "met"
    for name in ("slow line", "slow order", "step never"):
        assert bench.judged(name)["seen"] == "the search takes more than 2 s of CPU time"


@pytest.mark.thorough
def test_an_interrupt_ends_a_search(bench: Bench):
    bench.write(f"""sh("dull", "echo {"a" * 40}!; exec sleep 1000"),""")
    bench.expect("expect: [{log: '(a+)+$', process: dull}]")
    run = bench.start("--for=1000")
    log = bench.evidence / "smoke.log"
    wait_until(lambda: log.exists() and "ready" in log.read_text("utf-8"), "the run is ready")
    run.send_signal(signal.SIGTERM)
    assert run.wait(60) == 143
