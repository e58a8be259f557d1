"""Actions in bags: recorded from a server, shown, published, and sent to a server again."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.bag.reader import Bag
from tests.bag.ros.test_record import recording
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher
from tests.support.waiting import wait_until
from tests.support.workspaces import BuiltWorkspace

ACTION = "/execute"
TYPE = "fleet_interfaces/action/ExecuteTask"
FEEDBACK, STATUS = (f"{ACTION}/_action/{name}" for name in ("feedback", "status"))
SERVER = "tests.support.task_server"


@pytest.fixture
def env(fleet_workspace: BuiltWorkspace, tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path / "log") as env:
        yield fleet_workspace.environment(env)


def send_goal(env: dict[str, str], task_id: int) -> str:
    goal = f"assignment: {{task: work, task_id: {task_id}}}"
    answer = launcher(env, "action", "send_goal", "execute", TYPE, goal)
    assert "SUCCEEDED" in answer.out, answer
    return answer.out


@pytest.mark.thorough
def test_an_action_is_recorded_shown_and_published(env, tmp_path: Path):
    bag = tmp_path / "bag"
    with (
        talking(env, SERVER),
        recording(env, bag, "--actions", ACTION) as recorder,
    ):
        info = ("topic", "info", FEEDBACK)
        wait_until(lambda: "Subscription count: 1" in launcher(env, *info).out, "the recorder")
        send_goal(env, 3)
        wait_until(lambda: bag_counts(bag).get(FEEDBACK, 0) == 3, "three feedbacks")
        assert recorder.end() == 0, recorder.text
    counts = bag_counts(bag)
    assert set(counts) == {FEEDBACK, STATUS}  # nothing publishes events of its services
    answer = launcher(env, "bag", "info", str(bag), "--json")
    (document,) = json.loads(answer.out)["bags"]
    assert (document["topics"], document["services"]) == ([], [])
    (action,) = document["actions"]
    assert (action["name"], action["type"]) == (ACTION, TYPE)
    with talking(env, "tests.support.bag_listener", f"{FEEDBACK}={TYPE}_FeedbackMessage") as one:
        played = launcher(env, "bag", "play", str(bag), "--actions", ACTION)
        assert played.code == 0, played
        assert one.stdout is not None
        heard = [json.loads(one.stdout.readline()) for _ in range(3)]
    recorded = [message.data for message in Bag(str(bag)).messages([FEEDBACK])]
    assert [bytes.fromhex(data) for _, data, _ in heard] == recorded


def bag_counts(bag: Path) -> dict[str, int]:
    return dict(Bag(str(bag)).extent.counts)
