"""`action echo`: feedback and states of a real server, and events of services."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from tests.support.action_site import TYPE, WAIT, Site
from tests.support.any_message import has
from tests.support.json_forms import fit
from tests.support.node_process import line_of
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import eventually
from tests.support.workspaces import BuiltWorkspace

SERVER = "tests.support.task_server"
EVENT = {"info": {"event_type": 1}, "request": [{"goal": {"assignment": {"task": "work"}}}]}
NO_EVENTS = (
    "hint: the services of '/execute' publish no events: their introspection is off "
    "(Jazzy has none for actions, so there only feedback and status are printed)\n"
)


@pytest.fixture
def site(fleet_workspace: BuiltWorkspace, tmp_path: Path) -> Iterator[Site]:
    with ros_domain(tmp_path) as env, talking(fleet_workspace.environment(env), SERVER):
        yield Site(env, fleet_workspace.root)


def messages(program: subprocess.Popen[str], interfaces: set[str]) -> dict[str, dict]:
    """The first message of each interface, until there are all."""
    found: dict[str, dict] = {}
    while interfaces - found.keys():
        text = "".join(iter(lambda: line_of(program.stdout), "---\n"))
        first, _, rest = text.partition("\n")
        assert first.startswith("interface: "), text
        found.setdefault(first.removeprefix("interface: "), yaml.safe_load(rest))
    return found


def test_feedback_and_states_are_printed(site):
    with site.pursuing(), site.going_on("action", "echo", "/execute") as program:
        found = messages(program, {"FEEDBACK_TOPIC", "STATUS_TOPIC"})
    assert set(found) == {"FEEDBACK_TOPIC", "STATUS_TOPIC"}
    assert list(found["FEEDBACK_TOPIC"]) == ["goal_id", "feedback"]
    assert has(found["FEEDBACK_TOPIC"], {"feedback": {"progress": 0.0}})
    assert found["STATUS_TOPIC"]["status_list"][-1]["status"] in (1, 2)


@pytest.mark.thorough
def test_events_of_services_have_names(site):
    """Published as a server of Kilted does: rclpy of Jazzy has no introspection of actions."""
    event = ("topic", "pub", "/execute/_action/send_goal/_service_event", f"{TYPE}_SendGoal_Event")
    words = ("action", "echo", "execute", TYPE, "-i", "goal_service | FEEDBACK_TOPIC")
    with site.going_on(*event, yaml.safe_dump(EVENT), "-r", "10", "-p", "999"):
        with site.going_on(*words, "--flow-style") as program:
            found = messages(program, {"GOAL_SERVICE"})["GOAL_SERVICE"]
        assert has(found, {"info": {"event_type": "REQUEST_RECEIVED"}, "response": []}), found
        assert found["request"][0]["goal"]["assignment"]["task"] == "work"
        with site.going_on(*words, "--csv") as program:
            assert line_of(program.stdout) == "interface: GOAL_SERVICE\n"
            assert line_of(program.stdout).startswith("1,")
        with site.going_on(*words, "--json") as program:
            (shown,) = fit("action echo", line_of(program.stdout))
    assert shown["interface"] == "GOAL_SERVICE"
    assert shown["message"]["info"]["event_type"] == "REQUEST_RECEIVED"


@pytest.mark.thorough
def test_the_styles_of_feedback(site):
    with site.pursuing():
        words = ("echo", "/execute", "-i", "feedback_topic", "--timeout", "3")
        shown = eventually(lambda: site.action(*words, "--no-arr"), lambda one: one.out)
        assert shown.lines[:3] == [
            "interface: FEEDBACK_TOPIC",
            "goal_id:",
            "  uuid: '<array type: uint8[16]>'",
        ]
        assert (shown.err, shown.code) == ("", 0)
        assert set(shown.lines[::6]) == {"interface: FEEDBACK_TOPIC"}
        lines = eventually(lambda: site.action(*words, "--json"), lambda one: one.out)
    forms = fit("action echo", lines.out)
    assert {one["topic"] for one in forms} == {"/execute/_action/feedback"}
    assert json.loads(lines.lines[0])["message"]["feedback"] == {"progress": 0.0}


@pytest.mark.thorough
def test_that_services_publish_no_events_is_said_once(site):
    silent = site.action(
        "echo", "/execute", "-i", "CANCEL_SERVICE|RESULT_SERVICE", "--timeout", "1"
    )
    assert (silent.out, silent.code) == ("", 1)
    assert silent.err == f"{NO_EVENTS}no message on /execute within 1 s\n"
    with site.pursuing():
        both = eventually(
            lambda: site.action("echo", "/execute", "--timeout", "2"), lambda one: one.out
        )
    assert (both.err, both.code) == (NO_EVENTS, 0)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["/exekute"], "Cannot find type for '/exekute'\nhint: did you mean '/execute'?\n"),
        (["/execute", "a/action/B"], "The action type 'a/action/B' is invalid\nhint: "),
        (
            ["/execute", "-i", "FEEDBACK_TOPIC| STATUS"],
            '"STATUS" is incorrect interface name.\nhint: ',
        ),
        (["/execute", "-i", ""], "Input action interface name is empty.\n"),
    ],
    ids=["name", "type", "interface", "empty"],
)
def test_mistakes(site, words, error):
    answer = site.action("echo", *words, "--spin-time", "20")
    assert (answer.out, answer.code) == ("", 1)
    assert answer.err.startswith(error), answer


@pytest.mark.thorough
def test_a_goal_whose_end_is_not_awaited_goes_on(site):
    sent = site.send_goal(WAIT, "-t", "0")
    assert sent.lines[-1] == "Timed out waiting for result after 0 seconds."
    hint = "hint: the goal goes on; -t 0 does not wait for its end\n"
    assert (sent.err, sent.code) == (hint, 0)
    words = ("echo", "/execute", "-i", "STATUS_TOPIC", "--timeout", "3", "--json")
    shown = eventually(lambda: site.action(*words), lambda one: one.out)
    assert shown.json()["message"]["status_list"][-1]["status"] in (1, 2)


@pytest.mark.thorough
def test_now_in_a_goal_is_the_time_when_it_is_sent(site):
    sent = site.send_goal("assignment: {task: work, assigned: now}")
    (seconds, _) = re.findall(r" sec: (\d+)\n", sent.out)  # of the goal and of the result
    assert int(seconds) > 1_700_000_000
