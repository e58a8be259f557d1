"""`lifecycle` against real lifecycle nodes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.ros_domain import Verb, patient_verb, ros_domain, talking
from tests.support.verbs import eventually

UNCONFIGURED = """\
- configure [1]
\tStart: unconfigured
\tGoal: configuring
- shutdown [5]
\tStart: unconfigured
\tGoal: shuttingdown
"""


@pytest.fixture
def lifecycle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Verb]:
    """`lifecycle("get")` in a domain with the nodes of tests.support.lifecycle_nodes."""
    with ros_domain(tmp_path) as env, talking(env, "tests.support.lifecycle_nodes"):
        verb = patient_verb(env, monkeypatch)
        yield lambda *words: verb("lifecycle", *words)


def test_nodes_are_those_with_a_lifecycle(lifecycle):
    assert lifecycle("nodes").lines == ["/pump", "/site/stuck", "/slow"]
    assert lifecycle("nodes", "-a").lines == ["/_hidden", "/pump", "/site/stuck", "/slow"]
    assert lifecycle("nodes", "--count-nodes").out == "3\n"
    assert lifecycle("nodes", "--json", "--all").json()["nodes"][0] == {"name": "/_hidden"}


@pytest.mark.thorough
def test_states_are_printed_as_by_ros2(lifecycle):
    assert lifecycle("get", "pump").out == "unconfigured [1]\n"
    assert lifecycle("get").lines == [
        "/pump: unconfigured [1]",
        "/site/stuck: unconfigured [1]",
        "/slow: unconfigured [1]",
    ]
    assert "/_hidden: unconfigured [1]" in lifecycle("get", "--include-hidden-nodes").lines
    more = lifecycle("get", "/pump", "-t")
    assert more.lines == ["unconfigured [1]", "- configure [1]", "- shutdown [5]"]
    possible = [{"id": 1, "label": "configure"}, {"id": 5, "label": "shutdown"}]
    state = {"id": 1, "label": "unconfigured"}
    assert lifecycle("get", "/pump", "-t", "--json").json()["nodes"] == [
        {"name": "/pump", "state": state, "transitions": possible}
    ]


def test_a_node_goes_through_its_states(lifecycle):
    assert lifecycle("list", "/pump").out == UNCONFIGURED
    every = lifecycle("list", "/pump", "--all").out
    assert UNCONFIGURED.splitlines()[0] in every
    assert "- activate [3]\n\tStart: inactive\n\tGoal: activating\n" in every
    assert lifecycle("set", "/pump", "configure").out == "Transitioning successful\n"
    assert lifecycle("set", "pump", "3").out == "Transitioning successful\n"
    assert lifecycle("get", "/pump").out == "active [3]\n"
    document = lifecycle("set", "/pump", "shutdown", "--json").json()
    assert document == {
        "version": 1,
        "node": "/pump",
        "transition": {"id": 7, "label": "shutdown"},
        "done": True,
    }
    assert lifecycle("get", "/pump").out == "finalized [4]\n"
    assert lifecycle("list", "/_hidden", "--json").json()["transitions"][0] == {
        "id": 1,
        "label": "configure",
        "start": "unconfigured",
        "goal": "configuring",
    }


@pytest.mark.thorough
def test_a_transition_that_the_state_lacks_is_not_requested(lifecycle):
    answer = lifecycle("set", "/pump", "activate")
    lacks = "Unknown transition requested, available ones are:\n- configure [1]\n- shutdown [5]\n"
    assert (answer.out, answer.err, answer.code) == ("", lacks, 1)
    near = lifecycle("set", "/pump", "confgure")
    assert near.err == f"{lacks}hint: did you mean 'configure'?\n"


@pytest.mark.thorough
def test_a_transition_that_fails(lifecycle):
    assert lifecycle("set", "/site/stuck", "configure").code == 0
    answer = lifecycle("set", "/site/stuck", "activate")
    assert (answer.out, answer.code) == ("", 1)
    assert answer.err.startswith("Transitioning failed\nhint: '/site/stuck' refused it, or a call")
    assert lifecycle("get", "/site/stuck").out == "inactive [2]\n"


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("/plain", "'/plain' has no lifecycle; those that have: lifecycle nodes"),
        ("/pomp", "did you mean '/pump'?"),
        ("site/stuk", "did you mean '/site/stuck'?"),
    ],
)
@pytest.mark.parametrize("words", [["get"], ["list"], ["set", "configure"]], ids=lambda w: w[0])
def test_a_node_that_is_not_there(lifecycle, words, name, hint):
    answer = lifecycle(words[0], name, *words[1:], "--spin-time", "2")
    assert (answer.out, answer.code) == ("", 1)
    assert answer.err.endswith(f"Node not found\nhint: {hint}\n")


@pytest.mark.thorough
def test_time_limits(lifecycle):
    endless = lifecycle("set", "/slow", "configure", "--timeout", "1")
    assert (endless.out, endless.code) == ("", 1)
    assert endless.err == (
        "'/slow' has not ended the transition after 1 s\nhint: it may go on: lifecycle get /slow\n"
    )
    # it may have begun only now
    one = eventually(
        lambda: lifecycle("get", "/slow", "--timeout", "1"), lambda answer: answer.code == 1
    )
    silence = "service '/slow/get_state' did not answer within 1 s"
    assert one.err == f"{silence}\nhint: its node may be busy or stopped: node ps\n"
    every = eventually(
        lambda: lifecycle("get", "--timeout", "2"), lambda answer: len(answer.lines) == 2
    )
    assert every.lines == ["/pump: unconfigured [1]", "/site/stuck: unconfigured [1]"]
    problem = silence.replace("1 s", "2 s")
    assert every.err == f"Exception while calling service of node '/slow': {problem}\n"
    assert every.code == 1
