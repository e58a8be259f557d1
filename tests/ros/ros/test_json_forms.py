"""The forms of the ROS verbs, on real nodes."""

from __future__ import annotations

import select
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import pytest

from tests.support.json_forms import fit
from tests.support.node_process import line_of
from tests.support.ros_domain import Verb, patient_verb, ros_domain, talking
from tests.support.verbs import Answer, eventually, going_on, in_process, launcher
from tests.support.waiting import wait_until
from tests.support.workspaces import BuiltWorkspace

TALKER = "/talker speed"
SWITCH = "/switch std_srvs/srv/SetBool"
CASES = {
    "topic list": "",
    "topic find": "std_msgs/msg/String",
    "topic type": "/chatter",
    "topic info": "/weak",
    "topic echo": "/chatter --once -i",
    "topic pub": "/chatter std_msgs/msg/String 'data: x' --times 2 --rate 20 --keep-alive 0",
    "topic hz": "/chatter --for 2.2",
    "topic bw": "/chatter --for 2.2",
    "topic delay": "/points --for 2.2",
    "node list": "",
    "node info": "/talker",
    "node ps": "-a",
    "param list": "/talker --param-type",
    "param get": TALKER,
    "param dump": "/site/east/listener",
    "param set": f"{TALKER} 1.5",
    "param describe": TALKER,
    "service list": "",
    "service find": "std_srvs/srv/SetBool",
    "service type": "/switch",
    "service info": "/switch",
    "service call": f"{SWITCH} 'data: true'",
    "action list": "",
    "action find": "std_msgs/action/None",
    "lifecycle nodes": "",
    "graph": "",
}


@pytest.mark.thorough
@pytest.mark.parametrize("case", CASES)
def test_the_form_of_a_verb_of_ros(verb: Verb, case: str):
    words = (*case.split(), *shlex.split(CASES[case]), "--json")
    answer = eventually(lambda: verb(*words), lambda answer: answer.code == 0)
    fit(case, answer.out)


@pytest.mark.thorough
def test_the_forms_of_changes(verb: Verb, env: dict[str, str], tmp_path: Path):
    file = tmp_path / "parameters.yaml"
    file.write_text(verb("param", "dump", "/talker").out, encoding="utf-8")
    fit("param load", verb("param", "load", "/talker", str(file), "--json").out)
    extra = ("param", "set", "/site/east/listener", "extra", "1")
    assert verb(*extra, "--json", "--atomic").code == 0
    deleted = verb("param", "delete", "/site/east/listener", "extra", "--json")
    (answer,) = fit("param delete", deleted.out)
    assert answer["parameters"] == [{"name": "extra", "done": True, "reason": None}]
    refused = verb("param", "set", "/talker", "speed", "9.0", "--json")
    (answer,) = fit("param set", refused.out)
    assert (refused.code, answer["parameters"][0]["done"]) == (1, False)
    unset = verb("param", "get", "/site/east/listener", "nosuch", "--json")
    for words in (("/talker", "speed", "name"), ("speed",)):
        fit("param get", verb("param", "get", *words, "--json").out)
    (answer,) = fit("param get", unset.out)
    assert (answer["type"], answer["value"]) == ("not set", None)


@pytest.mark.thorough
def test_the_forms_of_differences(verb: Verb, env: dict[str, str], tmp_path: Path):
    file = tmp_path / "graph.json"
    file.write_text(verb("graph", "--json").out, encoding="utf-8")
    fit("graph --diff", verb("graph", "--diff", str(file), "--json").out)
    with going_on(env, "graph", "--watch", "--json", "--hidden") as watching:
        assert watching.stdout is not None
        # It does not show the graph that it begins with, and nothing says when it has that one: a
        # publisher comes and goes until one of the two is shown.
        wait_until(lambda: is_shown(watching.stdout, env), "a change")
        fit("graph --watch", line_of(watching.stdout))


def is_shown(stream: IO[str] | None, env: dict[str, str]) -> bool:
    with going_on(env, "topic", "pub", "/new", "std_msgs/msg/String"):
        if select.select([stream], [], [], 5.0)[0]:
            return True
    return bool(select.select([stream], [], [], 5.0)[0])


@pytest.mark.thorough
def test_the_form_of_events_of_services(tmp_path: Path):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.introspected_service"):
        words = ("service", "echo", "/told", "--json")
        with going_on(env, *words) as program:
            fit("service echo", line_of(program.stdout))


@pytest.fixture
def lifecycle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Verb]:
    with ros_domain(tmp_path) as env, talking(env, "tests.support.lifecycle_nodes"):
        verb = patient_verb(env, monkeypatch)
        yield lambda *words: verb("lifecycle", *words, "--json")


@pytest.mark.thorough
def test_the_forms_of_lifecycles(lifecycle: Verb):
    fit("lifecycle nodes", lifecycle("nodes").out)
    fit("lifecycle get", lifecycle("get", "-t").out)
    fit("lifecycle list", lifecycle("list", "/pump").out)
    fit("lifecycle set", lifecycle("set", "/pump", "configure").out)


@pytest.mark.thorough
def test_the_forms_of_actions(fleet_workspace: BuiltWorkspace, tmp_path: Path):
    kind, root = "fleet_interfaces/action/ExecuteTask", fleet_workspace.root
    with ros_domain(tmp_path) as env:

        def action(*words: str) -> Answer:
            return launcher(env, "action", *words, "--json", cwd=root)

        with talking(fleet_workspace.environment(env), "tests.support.task_server"):
            for verb, words in {
                "action list": (),
                "action find": (kind,),
                "action type": ("/execute",),
                "action info": ("/execute",),
            }.items():
                words = (verb.split()[1], *words, "--spin-time", "60")
                fit(verb, eventually(lambda w=words: action(*w), lambda one: one.code == 0).out)
            for task in ("work, task_id: 1", "fail", "refuse"):
                goal = f"assignment: {{task: {task}}}"
                answer = action("send_goal", "/execute", kind, goal, "-f", "--timeout", "10")
                fit("action send_goal", answer.out)
            echo = ("echo", "/execute", "-i", "STATUS_TOPIC", "--timeout", "3")
            fit("action echo", eventually(lambda: action(*echo), lambda one: one.out).out)


def test_the_forms_without_any_node(empty_domain: dict[str, str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", empty_domain["ROS_DOMAIN_ID"])
    for verb in ("topic list", "node list", "service list", "action list", "graph"):
        fit(verb, in_process(*verb.split(), "--json", "--spin-time", "0.1").out)
