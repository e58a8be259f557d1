"""Judges of parameters and services."""

from __future__ import annotations

from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.expect.message_conditions import fits, wanted_text
from launcher.smoke.judges import explain, graph
from launcher.smoke.judges.common import (
    Window,
    condition_text,
    judged,
    times_text,
    with_window,
)
from launcher.smoke.observe.facts import Facts, QueryAnswer


def _answers(expectation: Expectation, facts: Facts, when: Window) -> list[QueryAnswer]:
    return [a for a in facts.answers.get(expectation.key, ()) if a.at_s in when]


def _fits(answer: QueryAnswer, when: Window) -> Verdict:
    seen = f"{answer.value!r} after {when.since(answer.at_s)}"
    return when.met(seen=seen, at_s=answer.at_s)


def _last(answers: list[QueryAnswer]) -> str:
    """The last value rather than a later error, which there is for instance at the stop."""
    if not answers:
        return "there was no answer"
    values = [answer.value for answer in answers if answer.error is None]
    return f"the answer was {values[-1]!r}" if values else str(answers[-1].error)


def _parameter_text(expectation: Expectation) -> str:
    wanted = wanted_text(expectation.get("is"))
    node = expectation.get("node")
    return f"parameter {expectation.subject} of {node} {wanted}{times_text(expectation)}"


@with_window(_parameter_text)
def parameter(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    answers = _answers(expectation, facts, when)
    values = [answer for answer in answers if answer.error is None]
    for answer in values:
        if fits(answer.value, expectation.get("is")):
            return _fits(answer, when)
    node = expectation.get("node")
    process = facts.process_of(node)
    return when.not_yet(
        seen=_last(answers),
        guess=None if values else _unanswered(answers, node, facts),
        about=() if process is None else (process,),
    )


def _unanswered(answers: list[QueryAnswer], node: str, facts: Facts) -> str | None:
    """The cause; a running node has given it in its answer."""
    alive = set(facts.graph().nodes) - set(facts.graph().ghosts)
    if node in alive and answers:
        return answers[-1].hint
    return explain.missing_node(node, facts)


def _service_text(expectation: Expectation) -> str:
    if expectation.get("call") is False:
        of_type = f" of type {expectation.get('type')}" if expectation.get("type") else ""
        return f"service {expectation.subject}{of_type} exists{times_text(expectation)}"
    condition = condition_text(expectation)
    return f"service {expectation.subject} responds{condition}{times_text(expectation)}"


@with_window(_service_text)
def service(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    if expectation.get("call") is False:
        return graph.offered_service(expectation, facts, when)
    answers = _answers(expectation, facts, when)
    given = [answer for answer in answers if answer.error is None]
    reasons = []
    for answer, (is_good, why) in zip(
        given, judged(expectation, [one.value for one in given]), strict=True
    ):
        if is_good:
            return _fits(answer, when)
        reasons.append(why)
    seen = _last(answers) + (f" ({reasons[-1]})" if reasons and reasons[-1] else "")
    if reasons and expectation.get("once"):
        return when.violated(seen=seen, at_s=answers[-1].at_s)
    guess = explain.missing_service(expectation.subject, facts)
    return when.not_yet(seen=seen, guess=guess)
