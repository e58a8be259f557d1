"""Actions in bags: recorded from a server, shown, published, and sent to a server again."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.serialization import deserialize_message

from launcher.bag.bag_model import Topic
from launcher.bag.reader import Bag
from launcher.bag.writer import BagWriter
from tests.bag.ros.test_record import recording
from tests.support.node_process import line_of
from tests.support.repository import REPOSITORY
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
        heard = [json.loads(line_of(one.stdout)) for _ in range(3)]
    recorded = [message.data for message in Bag(str(bag)).messages([FEEDBACK])]
    assert [bytes.fromhex(data) for _, data, _ in heard] == recorded


def bag_counts(bag: Path) -> dict[str, int]:
    return dict(Bag(str(bag)).extent.counts)


def last_statuses(bag: Path) -> list[int]:
    """Of the goals, in the order in which they were accepted."""
    found = [message.data for message in Bag(str(bag)).messages([STATUS])]
    if not found:
        return []
    return [one.status for one in deserialize_message(found[-1], GoalStatusArray).status_list]


@pytest.mark.thorough
def test_recorded_goals_are_sent_to_the_server_again(env, tmp_path: Path):
    bag, seen = tmp_path / "events", tmp_path / "seen"
    words = [sys.executable, "-m", "tests.support.action_events", str(bag)]
    subprocess.run(words, env=env, cwd=REPOSITORY, check=True)
    ends = [GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED]
    with talking(env, SERVER), recording(env, seen, "--actions", ACTION) as recorder:
        info = ("topic", "info", STATUS)
        wait_until(lambda: "Subscription count: 1" in launcher(env, *info).out, "the recorder")
        for times in (1, 2):  # under new ids
            play = launcher(env, "bag", "play", str(bag), "--send-actions-as-client")
            assert (play.code, play.err) == (0, "playing 3 topics\nsent 5 requests\n"), play
            wait_until(lambda n=times: last_statuses(seen) == ends * n, "the end of both goals")
        assert recorder.end() == 0, recorder.text
    assert bag_counts(seen)[FEEDBACK] >= 4


@pytest.mark.thorough
def test_what_a_server_publishes_is_not_sent_as_client(env, tmp_path: Path):
    bag = tmp_path / "bag"
    writer = BagWriter(str(bag))
    writer.add_topic(Topic(name=FEEDBACK, type=f"{TYPE}_FeedbackMessage"))
    writer.close()
    answer = launcher(env, "bag", "play", str(bag), "--send-actions-as-client")
    assert (answer.code, answer.err.splitlines()[0]) == (1, "no topic of the bag is played"), answer
