"""Lifecycle transitions whose events or answers are lost."""

from __future__ import annotations

import pytest

from launcher.ros.helpers.lifecycle_client import (
    MAX_QUESTIONS,
    OVERDUE_S,
    REFUSED,
    StateChange,
    TransitionRequest,
)

CONFIGURE = 1
BEGUN, DONE = StateChange("unconfigured", "configuring"), StateChange("configuring", "inactive")
BACK = StateChange("configuring", "unconfigured")
LATE_S = OVERDUE_S + 0.1


def configure(state: str | None = "unconfigured") -> TransitionRequest:
    return TransitionRequest(CONFIGURE, 0.0, state=state)


def test_nothing_is_inferred_if_all_events_arrive():
    request = configure()
    request.answer(True, 0.1)
    assert request.on_event(BEGUN, 0.1) == request.on_event(DONE, 0.2) == []
    assert not request.is_overdue(LATE_S * 2)
    assert (request.succeeded, request.error, request.is_settled) == (True, None, True)


def test_missing_events_are_inferred_from_the_answer():
    request = configure()
    request.answer(True, 0.5)
    assert not request.is_overdue(1.4)
    assert request.is_overdue(1.6)
    assert request.finish() == [BEGUN, DONE]
    assert request.is_settled


def test_a_first_event_that_was_lost_comes_before_the_second():
    request = configure()
    assert request.on_event(DONE, 0.1) == [BEGUN]
    assert request.succeeded


def test_a_lost_answer_is_inferred_from_the_events():
    request = configure()
    request.on_event(BEGUN, 0.1)
    request.on_event(DONE, 0.2)
    assert (request.succeeded, request.error) == (True, None)
    assert not request.is_overdue(LATE_S * 2)  # whatever state the node has by now


def test_if_everything_is_lost_the_state_decides():
    request = configure()
    assert request.is_overdue(LATE_S)
    assert request.on_state("configuring", LATE_S) == []
    assert request.succeeded is None
    assert request.on_state("inactive", LATE_S) == [BEGUN, DONE]
    assert (request.succeeded, request.is_settled) == (True, True)


def test_a_node_that_was_in_the_state_before_has_not_made_the_transition():
    request = configure(state="inactive")
    assert request.on_state("inactive", LATE_S) == []
    assert (request.succeeded, request.error) == (False, "the node is inactive")


@pytest.mark.parametrize("heard", [[], [BEGUN]], ids=["nothing", "the first step"])
def test_a_refusal_ends_in_the_state_that_the_node_has(heard: list[StateChange]):
    request = configure()
    request.answer(False, 0.1)
    for step in heard:
        request.on_event(step, 0.1)
    assert (request.succeeded, request.error, request.is_settled) == (False, REFUSED, False)
    assert request.is_overdue(0.2 + OVERDUE_S)
    assert [*heard, *request.on_state("unconfigured", 1.2)] == [BEGUN, BACK]
    assert request.is_settled


@pytest.mark.parametrize(
    "steps",
    [
        [BEGUN, BACK],
        [
            BEGUN,
            StateChange("configuring", "errorprocessing"),
            StateChange("errorprocessing", "finalized"),
        ],
    ],
    ids=["failure", "error"],
)
def test_a_refusal_without_an_answer_is_inferred_from_the_events(steps: list[StateChange]):
    request = configure()
    for step in steps:
        assert request.on_event(step, 0.1) == []
    assert (request.succeeded, request.error, request.is_settled) == (False, REFUSED, True)


def test_an_event_of_another_transition_is_left_alone():
    request = configure()
    assert request.on_event(StateChange("inactive", "activating"), 0.1) is None
    request.on_event(BEGUN, 0.1)
    assert request.on_event(BEGUN, 0.2) is None


def test_a_transition_that_never_begins_is_an_error_at_the_timeout():
    request = configure()
    for number in range(1, MAX_QUESTIONS + 1):
        assert request.is_overdue(number * LATE_S)
        assert request.on_state("unconfigured", number * LATE_S) == []
    assert request.error == "the node did not answer, and is unconfigured"
    assert request.is_settled
