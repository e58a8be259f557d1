"""Explanations for waits in vain, from the recorded facts."""

from __future__ import annotations

import re
from typing import Any

import pytest

from launcher.smoke.judges import explain
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import Facts, GraphSeen, ObservedMessage, QueryAnswer
from launcher.smoke.run.waits import NotSeenError, Waits
from tests.smoke.unit.facts import graph, lines, publisher, running, started, verdict

TWO = {"events": started("robot_1-1", "robot_2-2")}
SAID = (*lines("[INFO] done"), *lines("[WARN] Battery low", process="robot_2-2", at_s=2.0))


@pytest.mark.parametrize(
    ("pattern", "options", "guess"),
    [
        ("Battery", {"process": "robot_1"}, "robot_2-2 printed such a line, at 2.0 s"),
        ("Battery", {"process": "robto_1"}, "no process is named robto_1; there are: robot_1-1"),
        ("Battery", {"process": "robot_2", "since_s": 5.0}, "it came before, at 2.0 s of the run"),
        ("Battery", {"process": "*", "level": "ERROR"}, "its level is WARN, not ERROR"),
        ("battery", {"process": "*"}, "differs in upper and lower case: [WARN] Battery low"),
        ("Battery", {"process": "*", "level": "WARN"}, None),  # it came, but not often enough
        ("nothing like it", {"process": "*"}, None),
    ],
)
def test_a_line_that_did_not_come(pattern: str, options: dict[str, Any], guess: str | None):
    given = {"level": None, "since_s": 0.0, **options}
    found = explain.missing_line(
        re.compile(pattern), facts=running(9.0, lines=SAID, **TWO), **given
    )
    assert found is None if guess is None else found is not None and guess in found


def heard(content: Any, at_s: float) -> ObservedMessage:
    return ObservedMessage(at_s=at_s, topic="/task", content=content)


def seen_graph(**more: Any) -> Facts:
    snapshot = graph(publisher("/tasks"), at_s=1.0)
    assert isinstance(snapshot, GraphSeen)
    return running(9.0, graphs=(snapshot,), **more)


@pytest.mark.parametrize(
    ("facts", "since_s", "guess"),
    [
        (seen_graph(), 0.0, "no node has this topic; did you mean '/tasks'?"),
        (
            seen_graph(messages=(heard({"data": 1}, 2.0),)),
            5.0,
            "the last of 1 messages came before",
        ),
        (seen_graph(messages=(heard({"data": 1}, 2.0),)), 0.0, "the last one was {'data': 1}"),
    ],
)
def test_a_message_that_did_not_come(facts: Facts, since_s: float, guess: str):
    assert guess in (explain.missing_message("/task", since_s, facts) or "")


def test_a_wait_in_vain_ends_with_the_guess_and_the_last_lines():
    recorder = FactRecorder()
    for line in SAID:
        recorder.add(line)
    for event in TWO["events"]:
        recorder.add(event)
    observed = Waits(recorder)
    with pytest.raises(NotSeenError) as told:
        observed.wait_for_log("Battery", process="robot_1", within_s=0.0)
    assert "maybe: robot_2-2 printed such a line, at 2.0 s\nthe last lines:\n" in str(told.value)
    with pytest.raises(NotSeenError, match="maybe: no process is named robto_1; there are: "):
        observed.wait_for_exit("robto_1", within_s=0.0)


def test_the_answer_of_the_node_explains_a_misspelt_parameter():
    entry = "name: p, parameter: speeed, node: /talker, is: 1.5"
    answer = QueryAnswer(
        at_s=3, error="/talker has no parameter 'speeed'", hint="did you mean 'speed'?"
    )
    there = graph(publisher("/a", node="/talker"), at_s=1.0)
    found = verdict(entry, answers={"parameter p": (answer,)}, graphs=(there,))
    assert (found.seen, found.guess) == (answer.error, answer.hint)
