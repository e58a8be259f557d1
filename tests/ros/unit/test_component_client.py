"""Load requests whose answers are lost, as a state machine."""

from __future__ import annotations

from launcher.ros.helpers.agent import WARN_AFTER_S, MissingNodes
from launcher.ros.helpers.component_client import (
    MAX_ABSENT,
    MAX_SENT,
    OVERDUE_S,
    ComponentLoad,
    Loaded,
    LoadStep,
)

OTHER = Loaded(1, "/other")


def test_an_overdue_answer_is_looked_up_in_the_list_of_nodes():
    request = ComponentLoad("/arm/n")
    assert request.next_step(0.0) is LoadStep.SEND
    assert request.next_step(OVERDUE_S / 2) is LoadStep.WAIT
    assert request.next_step(OVERDUE_S) is LoadStep.ASK
    assert request.next_step(OVERDUE_S * 1.5) is LoadStep.WAIT
    nodes = {1: "/other", 2: "/arm/n"}
    assert request.look_up(nodes, {OTHER}) == Loaded(2, "/arm/n")


def test_a_node_of_the_same_name_that_another_request_loaded_is_not_taken():
    request = ComponentLoad("/other")
    request.next_step(0.0)
    assert request.look_up({1: "/other"}, {OTHER}) is None


def test_a_plugin_that_chooses_the_name_is_the_newest_node():
    request = ComponentLoad("")
    request.next_step(0.0)
    assert request.look_up({1: "/other", 3: "/b", 2: "/c"}, {OTHER}) == Loaded(3, "/b")


def test_a_request_that_the_container_does_not_know_is_sent_again_and_given_up_in_the_end():
    request, steps, now_s = ComponentLoad("/n"), [], 0.0
    while (step := request.next_step(now_s)) is not LoadStep.GIVE_UP:
        steps.append(step)
        if step is LoadStep.ASK:
            request.look_up({}, set())
        now_s += OVERDUE_S
    assert steps == [LoadStep.SEND, *[LoadStep.ASK] * MAX_ABSENT] * MAX_SENT


def test_a_container_that_answers_nothing_is_not_sent_the_request_again():
    request = ComponentLoad("/n")
    assert request.next_step(0.0) is LoadStep.SEND
    assert {request.next_step(OVERDUE_S * number) for number in range(1, 100)} == {LoadStep.ASK}


def test_a_missing_node_is_reported_once_and_only_if_it_is_missing_for_long():
    missing = MissingNodes()
    assert missing.overdue(["/a"], 0.0) == []
    assert missing.overdue(["/a", "/b"], WARN_AFTER_S - 1) == []
    assert missing.overdue(["/a", "/b"], WARN_AFTER_S) == ["/a"]
    assert missing.overdue(["/a"], WARN_AFTER_S + 5) == []
    assert missing.overdue(["/b"], WARN_AFTER_S + 5) == []
