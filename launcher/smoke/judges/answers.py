"""Judges of answers: parameters and services."""

from __future__ import annotations

from launcher.smoke.expect.conditions import fits, wanted_text
from launcher.smoke.expect.expectation import Expectation, Period, Verdict, times_text
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import met, not_yet, violated, with_period
from launcher.smoke.observe.facts import Answer, Facts


def _answers(expectation: Expectation, facts: Facts, when: Period) -> list[Answer]:
    return [a for a in facts.answers.get(expectation.key, ()) if a.at_s in when]


def _parameter_text(expectation: Expectation) -> str:
    wanted = wanted_text(expectation.get("is"))
    node = expectation.get("node")
    return f"parameter {expectation.subject} of {node} {wanted}{times_text(expectation)}"


def _parameter(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    answers = _answers(expectation, facts, when)
    for answer in answers:
        if answer.error is None and fits(answer.value, expectation.get("is")):
            seen = f"{answer.value!r} after {when.since(answer.at_s)}"
            return met(expected, seen=seen, at_s=answer.at_s)
    node = expectation.get("node")
    return not_yet(
        when,
        expected,
        seen=_last(answers),
        guess=None if _is_answered(answers) else _unanswered(answers, node, facts),
        about=tuple(filter(None, [facts.process_of(node)])),
    )


def _unanswered(answers: list[Answer], node: str, facts: Facts) -> str | None:
    """A node that is there has said why it does not answer."""
    alive = set(facts.graph().nodes) - set(facts.graph().ghosts)
    if node in alive and answers:
        return answers[-1].hint
    return explain.missing_node(node, facts)


def _last(answers: list[Answer]) -> str:
    """The last real answer says more than that there was none later, at the stop for instance."""
    if not answers:
        return "there was no answer"
    real = [answer for answer in answers if answer.error is None]
    return f"the answer was {real[-1].value!r}" if real else str(answers[-1].error)


def _is_answered(answers: list[Answer]) -> bool:
    return any(answer.error is None for answer in answers)


def _service_text(expectation: Expectation) -> str:
    conditions = [expectation.get(name) for name in ("where", "fields")]
    texts = [condition.text for condition in conditions if condition is not None]
    condition = f" with {' and '.join(texts)}" if texts else ""
    return f"service {expectation.subject} answers{condition}{times_text(expectation)}"


def _service(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    answers = _answers(expectation, facts, when)
    reasons = []
    for answer in answers:
        holds, why = _fits(expectation, answer)
        if holds:
            seen = f"{answer.value!r} after {when.since(answer.at_s)}"
            return met(expected, seen=seen, at_s=answer.at_s)
        if answer.error is None:
            reasons.append(why)
    why = f" ({reasons[-1]})" if reasons and reasons[-1] else ""
    if reasons and expectation.get("once"):
        return violated(expected, seen=_last(answers) + why, at_s=answers[-1].at_s)
    guess = explain.missing_service(expectation.subject, facts)
    return not_yet(when, expected, seen=_last(answers) + why, guess=guess)


def _fits(expectation: Expectation, answer: Answer) -> tuple[bool, str | None]:
    if answer.error is not None:
        return False, None
    for name in ("where", "fields"):
        condition = expectation.get(name)
        if condition is not None:
            holds, why = condition.holds(answer.value)
            if not holds:
                return False, why
    return True, None


parameter = with_period(_parameter, _parameter_text)
service = with_period(_service, _service_text)
