"""`action` against a real server, and the topics and services of an action."""

from __future__ import annotations

import contextlib
import itertools
import json
import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from tests.support.action_site import TYPE, WAIT, Site
from tests.support.any_message import has
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import Answer, eventually
from tests.support.waiting import rest_of
from tests.support.workspaces import BuiltWorkspace

SERVER = "tests.support.task_server"
WORK = "assignment: {task: work, task_id: 2}"
IDS = itertools.count()


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path) as env:
        yield env


@pytest.fixture
def site(fleet_workspace: BuiltWorkspace, domain: dict[str, str]) -> Iterator[Site]:
    with talking(fleet_workspace.environment(domain), SERVER):
        yield Site(domain, fleet_workspace.root)


def read_until(program: subprocess.Popen[str], start: str) -> str:
    """The first line with this start."""
    assert program.stdout is not None
    seen = []
    for line in program.stdout:
        if line.startswith(start):
            return line
        seen.append(line)
    assert program.stderr is not None
    raise AssertionError(f"no {start!r} in {seen}; {program.stderr.read()}")


@pytest.mark.thorough
def test_actions_are_listed_found_and_typed(site):
    assert site.graph("list").lines == ["/execute"]
    assert site.graph("list", "-t").lines == [f"/execute [{TYPE}]"]
    assert site.graph("list", "-c").lines == ["1"]
    listed = site.graph("list", "--json").json()["actions"]
    assert listed == [{"name": "/execute", "types": [TYPE]}]
    assert site.graph("type", "execute").lines == [TYPE]
    assert site.graph("find", "fleet_interfaces/ExecuteTask").lines == ["/execute"]
    assert site.graph("find", TYPE, "-c").lines == ["1"]
    unknown = site.graph("type", "/exekute")
    assert (unknown.out, unknown.code) == ("", 1)
    assert unknown.err == "Unknown action '/exekute'\nhint: did you mean '/execute'?\n"
    other = site.graph("find", "fleet_interfaces/action/ExecuteTsk")
    assert (other.out, other.err) == ("", f"hint: did you mean {TYPE}?\n")


@pytest.mark.thorough
def test_info_names_the_nodes(site):
    about = ["Action: /execute", "Action clients: 0", "Action servers: 1"]
    assert site.graph("info", "/execute").lines == [*about, "    /task_server"]
    assert site.graph("info", "/execute", "-t").lines == [*about, f"    /task_server [{TYPE}]"]
    assert site.graph("info", "/execute", "-c").lines == about
    document = site.graph("info", "execute", "--json").json()
    assert document == {
        "version": 1,
        "name": "/execute",
        "clients": [],
        "servers": [{"node": "/task_server", "types": [TYPE]}],
    }
    unknown = site.graph("info", "/exekute")
    assert unknown.lines == ["Action: /exekute", "Action clients: 0", "Action servers: 0"]
    assert (unknown.err, unknown.code) == ("hint: did you mean '/execute'?\n", 0)


def test_a_goal_that_succeeds_prints_what_ros2_prints(site):
    answer = site.action("send_goal", "execute", TYPE, "--stdin", text=WORK)
    goal_id = re.search("ID: ([0-9a-f]{32})\n", answer.out)
    assert goal_id is not None, answer
    assert answer.out == (
        "Waiting for an action server to become available...\n"
        "Sending goal:\n"
        "     assignment:\n"
        "  task_id: 2\n"
        "  task: work\n"
        "  robot_id: ''\n"
        "  priority: 0\n"
        "  assigned:\n"
        "    sec: 0\n"
        "    nanosec: 0\n"
        "\n"
        f"Goal accepted with ID: {goal_id[1]}\n"
        "\n"
        "Result:\n"
        "    took:\n"
        "  sec: 2\n"
        "  nanosec: 0\n"
        "\n"
        "Goal finished with status: SUCCEEDED\n"
    )
    assert (answer.err, answer.code) == ("", 0)


@pytest.mark.thorough
def test_a_goal_as_json(site):
    answer = site.send_goal(WORK, "--json", "-f")
    accepted, *_, last = map(json.loads, answer.lines)
    assert (accepted["event"], len(accepted["goal_id"])) == ("accepted", 32)
    result = {"took": {"sec": 2, "nanosec": 0}}
    assert last == {"version": 1, "event": "ended", "status": "SUCCEEDED", "result": result}


@pytest.mark.thorough
def test_times_that_are_now_are_those_of_sending(site):
    goal = "assignment: {task: work, task_id: 1, assigned: now}"
    assert "\n    sec: 0\n" not in site.send_goal(goal).out
    request = f"{{goal_id: {{uuid: {[*range(1, 17)]}}}, goal: {{{goal}}}}}"
    words = ("/execute/_action/send_goal", f"{TYPE}_SendGoal", request, "--timeout", "10")
    called = eventually(lambda: site.call(*words), lambda answer: answer.code == 0)
    assert "assigned=" in called.out
    assert "Time(sec=0" not in called.lines[0]


def test_goals_that_fail_and_that_are_refused(site):
    failed = site.send_goal("assignment: {task: fail}")
    assert (failed.lines[-1], failed.code) == ("Goal finished with status: ABORTED", 1)
    # the answer may be lost
    refused = eventually(
        lambda: site.send_goal("assignment: {task: refuse}", "--timeout", "10"),
        lambda answer: "Goal was rejected." in answer.lines,
    )
    assert (refused.lines[-1], refused.code) == ("Goal was rejected.", 1)


@pytest.mark.parametrize("in_background", [pytest.param(False, marks=pytest.mark.thorough), True])
def test_ctrl_c_cancels_the_goal(site, in_background: bool):
    with site.pursuing("--feedback", in_background=in_background) as program:
        assert read_until(program, "Feedback:") == "Feedback:\n"
        assert read_until(program, "    progress") == "    progress: 0.0\n"
        program.send_signal(signal.SIGINT)
        assert read_until(program, "Canceling") == "Canceling goal...\n"
        out, err = rest_of(program)
    # The server goes on giving feedback until the request has arrived.
    feedback = "Feedback:\n    progress: 0.0\n\n"
    assert out.replace(feedback, "") == "Goal canceled.\n"
    assert (err, program.returncode) == ("", 130)
    eventually(lambda: status(site), lambda answer: last_status(answer) == 5)


def status(site: Site) -> Answer:
    return site.topic("echo", "/execute/_action/status", "--once")


def last_status(answer: Answer) -> int | None:
    """None if the verb has heard nothing: discovery may take longer than it waits."""
    document = next(yaml.safe_load_all(answer.out), None)
    return document["status_list"][-1]["status"] if document else None


@pytest.mark.thorough
def test_a_goal_that_takes_too_long_is_cancelled(site):
    answer = eventually(
        lambda: site.send_goal(WAIT, "--timeout", "3"),
        lambda answer: "Goal canceled." in answer.lines,
    )
    assert answer.err == "Timed out waiting for result after 3 seconds.\n"
    assert (answer.lines[-2:], answer.code) == (["Canceling goal...", "Goal canceled."], 1)


@pytest.mark.thorough
def test_lost_answers_are_concluded_from_the_status(
    fleet_workspace: BuiltWorkspace, domain: dict[str, str]
):
    site = Site(domain, fleet_workspace.root)
    with talking(fleet_workspace.environment(domain), "tests.support.silent_task_server"):
        answer = site.send_goal(WORK)
    assert any(line.startswith("Goal accepted with ID: ") for line in answer.lines)
    assert (answer.lines[-1], answer.code) == ("Goal finished with status: SUCCEEDED", 0)


@pytest.mark.thorough
def test_a_server_that_ends_is_not_waited_for(
    fleet_workspace: BuiltWorkspace, domain: dict[str, str]
):
    site = Site(domain, fleet_workspace.root)
    with contextlib.ExitStack() as stack:
        with talking(fleet_workspace.environment(domain), SERVER):
            program = stack.enter_context(site.pursuing())
            read_until(program, "Goal accepted")
        _, err = rest_of(program)
    assert (err, program.returncode) == ("the server of action '/execute' is gone\n", 1)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["/execute", "fleet_interfaces/action/ExecuteTsk"], "hint: did you mean ExecuteTask? ("),
        (["/execute", "fleet_interfaces/srv/CountTasks"], "The passed action type is invalid\n"),
        (["/execute", TYPE, "assinment: {}"], "hint: did you mean 'assignment'?"),
        (["/execute", TYPE, "assignment: {task_id: -1}"], "'assignment.task_id' takes a whole"),
        (["bad name!", TYPE], "Invalid service name: "),
        (["/nobody", TYPE, "-t", "1"], "server is not available after waiting 1 seconds.\n"),
    ],
    ids=["type", "kind", "field", "value", "name", "timeout"],
)
def test_goal_errors(fleet_workspace: BuiltWorkspace, domain: dict[str, str], words, error):
    site = Site(domain, fleet_workspace.root)
    answer = site.action("send_goal", *words, "--spin-time", "2")
    assert (answer.code, error in answer.err) == (1, True), answer


@pytest.mark.thorough
def test_an_action_is_used_by_its_topics_and_services(site):
    def call() -> Answer:
        uuid = [*range(n := next(IDS), n + 16)]
        request = {"goal_id": {"uuid": uuid}, "goal": yaml.safe_load(WAIT)}
        words = ("/execute/_action/send_goal", f"{TYPE}_SendGoal", yaml.safe_dump(request))
        return site.call(*words, "--json", "--timeout", "10")

    # the answer may be lost
    assert eventually(call, lambda answer: answer.code == 0).json()["response"]["accepted"]
    feedback = "/execute/_action/feedback"
    shown = site.topic("echo", feedback, "--once", "--field", "feedback")
    assert shown.out == "progress: 0.0\n---\n"
    rate = eventually(
        lambda: site.topic("hz", feedback, "--for", "3"), lambda answer: "average" in answer.out
    )
    assert "average rate: " in rate.out
    rare = site.topic("hz", "/execute/_action/status", "--filter", "m.status_list", "--for", "1")
    assert (rare.code, "on /execute/_action/status within 1 s\n" in rare.err) == (1, True), rare
    eventually(lambda: status(site), lambda answer: last_status(answer) in (1, 2))


@pytest.mark.thorough
def test_the_feedback_of_an_action_can_be_published(site):
    kind = f"{TYPE}_FeedbackMessage"
    values = {"goal_id": {"uuid": [*range(16)]}, "feedback": {"progress": 0.25}}
    words = ("topic", "pub", "/progress", kind, yaml.safe_dump(values), "-r", "20", "-w", "0")
    with site.going_on(*words, "-p", "999"):
        answer = site.topic("echo", "/progress", kind, "--once")
    assert has(next(yaml.safe_load_all(answer.out)), values), answer
