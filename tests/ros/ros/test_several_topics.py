"""`topic hz` and `bw` of several topics, and of all that there are."""

from __future__ import annotations

import json
import re

import pytest

from launcher.base.ros_errors import VerbError
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import GraphAccess
from launcher.ros.verbs.measurements import Bandwidths, MeasureOptions
from tests.support.verbs import Answer, eventually

HEADS = {
    "hz": ["topic", "rate", "min_delta", "max_delta", "std_dev", "window"],
    "bw": ["topic", "bandwidth", "window", "mean", "min", "max"],
}


def tables(answer: Answer) -> list[list[str]]:
    """The lines of each table: head, rule, and a line for each topic."""
    found = []
    lines = answer.lines
    for place, line in enumerate(lines):
        if line and set(line) == {"="}:
            found.append(lines[place - 1 : lines.index("", place)])
    return found


def rows(answer: Answer) -> list[str]:
    """The topics of the last table."""
    found = tables(answer)
    return [line.split()[0] for line in found[-1][2:]] if found else []


@pytest.mark.parametrize("name", ["hz", pytest.param("bw", marks=pytest.mark.thorough)])
def test_several_topics_are_a_table(verb, name):
    words = ("topic", name, "/chatter", "/points", "--for", "2.5")
    answer = eventually(lambda: verb(*words), lambda one: rows(one) == ["/chatter", "/points"])
    assert answer.lines[:2] == ["Subscribed to [/chatter]", "Subscribed to [/points]"]
    head, rule, *lines = tables(answer)[-1]
    assert head.split() == HEADS[name]
    assert rule == "=" * len(head)
    assert {len(line) for line in lines} == {len(head)}
    assert (answer.err, answer.code) == ("", 0)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["hz", "bw"])
def test_all_topics_are_found(verb, name):
    words = ("topic", name, "--all", "--for", "2.5")
    talking = ["/chatter", "/numbers", "/points", "/weak"]
    answer = eventually(lambda: verb(*words), lambda one: rows(one) == talking)
    count = re.fullmatch(r"Subscribing to all (\d+) available topics\.\.\.", answer.lines[0])
    assert count is not None
    subscribed = [line for line in answer.lines if line.startswith("Subscribed to [")]
    assert len(subscribed) == int(count[1])
    assert "Subscribed to [/_secret]" not in subscribed
    assert "\x1b" not in answer.out  # only a terminal is cleared
    assert answer.code == 0


@pytest.mark.thorough
def test_all_topics_as_json_and_hidden_ones(verb):
    words = ("topic", "--include-hidden-topics", "hz", "-a", "--for", "1.5", "--json")
    answer = eventually(lambda: verb(*words), lambda one: '"rate"' in one.out)
    documents = [json.loads(line) for line in answer.lines]
    totals = [one["topic"] for one in documents if one["event"] == "total"]
    assert {"/_secret", "/chatter", "/rosout"} <= set(totals)
    assert answer.err.startswith(f"Subscribing to all {len(totals)} available topics...\n")


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["hz", "bw"])
def test_no_topic_is_nothing_to_measure(empty_domain, monkeypatch, verb, name):
    monkeypatch.setenv("ROS_DOMAIN_ID", empty_domain["ROS_DOMAIN_ID"])
    answer = verb("topic", name, "--all", "--spin-time", "0.3")
    assert (answer.out, answer.code) == ("No topics available\n", 1)


@pytest.mark.thorough
@pytest.mark.parametrize("more", [[], ["/nosuch"]])
def test_notes_are_not_among_the_answers(verb, more):
    """Of a topic without publishers, and of publishers that differ."""
    answer = verb("topic", "hz", "/nosuch2", *more, "--for", "0.3", "--json")
    assert all(line.startswith("{") for line in answer.lines)
    assert "WARNING: topic [/nosuch2] does not appear to be published yet" in answer.err


def test_a_topic_of_an_unknown_type_is_left_out(capsys):
    options = MeasureOptions(
        access=GraphAccess(0, 1.0),
        topics=["a", "/b"],
        qos=QosOptions(),
        window=5,
        for_s=None,
        use_sim_time=False,
        json=False,
    )
    measurement = Bandwidths(options)
    measurement._drop("a", VerbError("The passed message type is invalid", hint="why"))
    assert measurement.topics == ["/b"]
    assert capsys.readouterr() == (
        "WARNING: failed to find message type for topic [a]\n",
        "The passed message type is invalid\nhint: why\n",
    )


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["hz", "bw"])
def test_without_a_known_type_nothing_is_left(verb, monkeypatch, name):
    def unknown(type_name: str) -> object:
        raise VerbError("The passed message type is invalid", hint=f"no type {type_name}")

    monkeypatch.setattr("launcher.ros.topics.listener.load_message", unknown)
    words = ("topic", name, "/chatter", "/points")
    answer = eventually(lambda: verb(*words), lambda one: one.out.count("failed to find") == 2)
    assert answer.lines == [
        f"WARNING: failed to find message type for topic [{topic}]"
        for topic in ("/chatter", "/points")
    ]
    assert answer.code == 1
