"""The whole fleet with its default settings, robot_3 late, one run for all tests here."""

from __future__ import annotations

import itertools
import json
import os
from dataclasses import dataclass

import psutil
import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from group_gp1 import qos, topics
from group_gp1.logic.messages import report_text
from group_gp1.nodes.qos_probe_node import UNKNOWN_NODE
from tests.support.domain import LISTENER, Domain, Heard
from tests.support.node_process import NodeProcess

ROBOTS = ("robot_1", "robot_2", "robot_3")
TASK_SECONDS = {"robot_1": 0.5, "robot_2": 2.0, "robot_3": 0.3}


@dataclass(kw_only=True)
class Fleet:
    """The running nodes and what an independent subscriber hears."""

    domain: Domain
    nodes: dict[str, NodeProcess]
    tasks: list[Heard]
    statuses: list[Heard]
    reports: list[Heard]
    sent_before_robot_3: list[Heard]

    def assignments(self) -> list[dict]:
        return [json.loads(heard.text) for heard in self.tasks]

    def statuses_of(self, robot_id: str) -> list[dict]:
        return [s for s in map(json.loads, texts(self.statuses)) if s["robot_id"] == robot_id]

    def done_ids(self, robot_id: str) -> set[str]:
        """Tasks that the robot says it has done; each status also names the last ten."""
        statuses = [s for s in self.statuses_of(robot_id) if s["status"] == "done"]
        return {task_id for s in statuses for task_id in s["completed"]}


def texts(messages: list[Heard]) -> list[str]:
    return [heard.text for heard in messages]


@pytest.fixture(scope="module")
def fleet(module_domain) -> Fleet:
    """Seven nodes; robot_3 starts when seven tasks are assigned, more than the backlog holds."""
    domain = module_domain
    tasks = domain.record(topics.TASKS, qos.tasks_profile(1000))
    statuses = domain.record(topics.STATUS, qos.STATUS)
    reports = domain.record(topics.REPORT, qos.REPORT)
    first = ("monitor", "debug_logger", "qos_probe", "robot_1", "robot_2")
    nodes = {name: domain.start(name) for name in first}
    domain.wait_for_nodes(*first)
    nodes["dispatcher"] = domain.start("dispatcher")
    domain.wait_until(lambda: len(tasks) >= 7, "seven tasks are assigned")
    before = list(tasks)
    nodes["robot_3"] = domain.start("robot_3")
    domain.wait_for_line(nodes["robot_3"], "Late joiner")
    fleet = Fleet(
        domain=domain,
        nodes=nodes,
        tasks=tasks,
        statuses=statuses,
        reports=reports,
        sent_before_robot_3=before,
    )
    domain.wait_until(lambda: all(len(fleet.done_ids(r)) >= 4 for r in ROBOTS), "four tasks each")
    return fleet


@pytest.fixture(scope="module")
def quiet_fleet(fleet) -> Fleet:
    """The same fleet when the dispatcher has stopped and every robot has worked off its queue."""
    assert fleet.nodes["dispatcher"].stop() == 0
    # Older ones may be from before the last assignment.
    seen = {robot_id: len(fleet.statuses_of(robot_id)) for robot_id in ROBOTS}

    def is_idle(robot_id: str) -> bool:
        latest = fleet.statuses_of(robot_id)[seen[robot_id] :][-3:]
        return len(latest) == 3 and len({(s["status"], s["task_id"]) for s in latest}) == 1

    def all_idle() -> bool:
        latest = [fleet.statuses_of(robot_id)[-1]["status"] for robot_id in ROBOTS]
        return set(latest) == {"done"} and all(map(is_idle, ROBOTS))

    fleet.domain.wait_until(all_idle, "every robot repeats its last done")
    return fleet


def test_robots_get_tasks_in_turn(fleet):
    robot_ids = [assignment["robot_id"] for assignment in fleet.assignments()]

    assert robot_ids == list(itertools.islice(itertools.cycle(ROBOTS), len(robot_ids)))


def test_one_task_is_assigned_every_second(fleet):
    times_s = [heard.sent_s for heard in fleet.tasks]
    assert comes_every(1.0, times_s)


def comes_every(period_s: float, times_s: list[float]) -> bool:
    """Not more often, and half as often at least: a timer skips what a busy machine misses."""
    periods = (times_s[-1] - times_s[0]) / period_s
    return len(times_s) - 2 <= periods <= 2 * (len(times_s) - 1)


def test_the_dispatcher_logs_each_assignment(fleet):
    expected = [f"Assigned task {a['task']} to {a['robot_id']}" for a in fleet.assignments()]

    log = fleet.nodes["dispatcher"].log_texts
    fleet.domain.wait_until(lambda: len(log()) >= len(expected), "each has its line")
    assert log()[: len(expected)] == expected
    assert expected[0] == "Assigned task pick_shelf_A3 to robot_1"


@pytest.mark.parametrize("robot_id", ROBOTS)
def test_a_robot_takes_only_its_own_tasks(fleet, robot_id):
    def worked_on() -> set[str]:
        return {s["task_id"] for s in fleet.statuses_of(robot_id) if s["task"]}

    def assigned(*robot_ids: str) -> set[str]:
        return {a["task_id"] for a in fleet.assignments() if a["robot_id"] in robot_ids}

    fleet.domain.wait_until(
        lambda: len(worked_on()) >= 2 and worked_on() <= assigned(robot_id), "two tasks of its own"
    )
    assert worked_on().isdisjoint(assigned(*(set(ROBOTS) - {robot_id})))


@pytest.mark.parametrize("robot_id", ROBOTS)
def test_a_robot_logs_start_and_end_of_each_task(fleet, robot_id):
    log = [x for x in fleet.nodes[robot_id].log_texts() if x.startswith(("Received", "Task"))]
    tasks = [text.split()[2] for text in log[0::2]]

    starts = [f"Received task {task} -- executing..." for task in tasks]
    ends = [f"Task {task} complete" for task in tasks]
    assert len(tasks) >= 2
    assert log == [text for pair in zip(starts, ends, strict=True) for text in pair][: len(log)]


@pytest.mark.parametrize("robot_id", ROBOTS)
def test_busy_goes_out_before_the_work_and_done_after_it(fleet, robot_id):
    # `done` is repeated, and BEST_EFFORT: where the first was lost, the next one was heard later.
    duration_s = TASK_SECONDS[robot_id]
    fleet.domain.wait_until(
        lambda: sum(t < duration_s + 0.5 for t in worked_s(fleet, robot_id)) >= 2, "two tasks"
    )
    assert all(t > duration_s - 0.05 for t in worked_s(fleet, robot_id))


def worked_s(fleet: Fleet, robot_id: str) -> list[float]:
    """Of each task, from the first `busy` that was heard to the first `done`, as they were sent."""
    busy_s, done_s = {}, {}
    for heard in fleet.statuses:
        status = json.loads(heard.text)
        if status["robot_id"] == robot_id and status["task"]:
            times = busy_s if status["status"] == "busy" else done_s
            times.setdefault(status["task_id"], heard.sent_s)
    return [done_s[task_id] - busy_s[task_id] for task_id in done_s.keys() & busy_s.keys()]


def test_a_late_joiner_receives_the_last_assignments(fleet):
    log = fleet.nodes["robot_3"].log_texts()
    backlog = [text.split(": ")[1].split(",")[0] for text in log if text.startswith("Backlog")]

    sent = [f"{a['task']} for {a['robot_id']}" for a in fleet.assignments()]
    last = sent.index(backlog[-1], len(fleet.sent_before_robot_3) - 1)
    # Five, less those that new ones have pushed out before robot_3 came to take them.
    latest = iter(sent[last - 4 : last + 1])
    assert all(assignment in latest for assignment in backlog)  # in this order
    received = f"Late joiner: received {len(backlog)} assignments"
    assert any(text.startswith(received) for text in log)


def test_a_late_joiner_carries_out_its_share_of_the_backlog(fleet):
    log = fleet.nodes["robot_3"].log_texts()
    mine = [text.split()[2] for text in log if text.startswith("Backlog") and "for robot_3" in text]
    taken = [text.split()[2] for text in log if text.startswith("Received task")]

    assert taken[: len(mine)] == mine


def test_every_endpoint_has_the_quality_of_service_of_its_topic(fleet):
    reliable, best_effort = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
    latched, volatile = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE
    status = (best_effort, volatile)
    expected = {
        topics.TASKS: {
            "publishers": {"dispatcher": (reliable, latched)},
            "subscriptions": dict.fromkeys((*ROBOTS, "debug_logger"), (reliable, latched)),
        },
        topics.STATUS: {
            "publishers": dict.fromkeys(ROBOTS, status),
            "subscriptions": {
                "monitor": status,
                "debug_logger": status,
                "qos_probe": (reliable, volatile),
            },
        },
        topics.REPORT: {
            "publishers": {"monitor": (reliable, volatile)},
            "subscriptions": {},
        },
    }

    def all_are_named() -> bool:
        """The name of a node arrives after its endpoints."""
        found = [endpoints(fleet, topic) for topic in expected]
        return UNKNOWN_NODE not in str(found)

    fleet.domain.wait_until(all_are_named, "the names of all nodes")
    assert {topic: endpoints(fleet, topic) for topic in expected} == expected


def endpoints(fleet: Fleet, topic: str) -> dict[str, dict]:
    """Reliability and durability by node, as the graph tells them, without the test's own."""
    graph = fleet.domain.listener

    def by_node(infos) -> dict:
        return {
            info.node_name: (info.qos_profile.reliability, info.qos_profile.durability)
            for info in infos
            if info.node_name != LISTENER and info.topic_type == "std_msgs/msg/String"
        }

    return {
        "publishers": by_node(graph.get_publishers_info_by_topic(topic)),
        "subscriptions": by_node(graph.get_subscriptions_info_by_topic(topic)),
    }


def test_the_depths_are_those_of_the_scenario():
    # discovery does not carry the depth, so this is the one thing the graph cannot tell
    assert (qos.TASKS.depth, qos.STATUS.depth) == (5, 3)


def test_a_mismatched_subscriber_receives_nothing_and_logs_why(fleet):
    probe = fleet.nodes["qos_probe"]
    fleet.domain.wait_for_line(probe, "Received 0 messages on /fleet/status, 3 publishers do not")
    explanation = "Incompatible QoS on /fleet/status: RELIABILITY, 3 publishers"
    fleet.domain.wait_for_line(probe, explanation)  # when the names of all nodes are known

    assert "[WARN]" in probe.matching(explanation)[0].text
    assert not [x for x in probe.matching("Received") if "Received 0 messages" not in x.text]


@pytest.mark.parametrize("robot_id", ROBOTS)
def test_the_publisher_logs_the_mismatch_too(fleet, robot_id):
    mismatch = "requesting incompatible QoS"
    fleet.domain.wait_for_line(fleet.nodes[robot_id], mismatch)
    warnings = fleet.nodes[robot_id].matching(mismatch)

    assert len(warnings) == 1
    assert "RELIABILITY" in warnings[0].text


def test_the_debug_logger_logs_every_task(fleet):
    for text in texts(fleet.tasks):
        fleet.domain.wait_for_line(fleet.nodes["debug_logger"], f"/fleet/tasks: {text}")


def test_the_debug_logger_logs_the_statuses(fleet):
    def logged() -> set[str]:
        log = fleet.nodes["debug_logger"].output
        heard = [text for text in texts(fleet.statuses) if f"/fleet/status: {text}" in log]
        return {json.loads(text)["robot_id"] for text in heard}

    # BEST_EFFORT: on a busy machine one or the other may lawfully be lost, to it or to the test
    fleet.domain.wait_until(lambda: logged() == set(ROBOTS), "one of each robot is logged")


def test_a_report_comes_every_two_seconds(fleet):
    fleet.domain.wait_until(lambda: len(fleet.reports) >= 5, "five reports")
    assert comes_every(2.0, [heard.sent_s for heard in fleet.reports])


def test_reported_counts_are_the_done_tasks_that_a_witness_saw(quiet_fleet):
    domain, nodes = quiet_fleet.domain, quiet_fleet.nodes
    expected = {robot_id: len(quiet_fleet.done_ids(robot_id)) for robot_id in ROBOTS}
    # The queue of a robot that was held up may have lost an assignment: it takes the rest.
    taken = {r: len(nodes[r].matching("Received task")) for r in ROBOTS}

    assert expected == taken
    for robot_id in ROBOTS:
        assigned = {a["task_id"] for a in quiet_fleet.assignments() if a["robot_id"] == robot_id}
        assert quiet_fleet.done_ids(robot_id) <= assigned
    text = report_text(expected)
    domain.wait_until(lambda: quiet_fleet.reports[-1].text == text, "the report has these counts")
    domain.wait_for_line(nodes["monitor"], text)


def test_an_idle_robot_goes_on_reporting_its_last_task(quiet_fleet):
    seen = len(quiet_fleet.statuses)

    def later() -> list[dict]:
        return [json.loads(text) for text in texts(quiet_fleet.statuses[seen:])]

    quiet_fleet.domain.wait_until(
        lambda: {status["robot_id"] for status in later()} == set(ROBOTS), "each reports"
    )
    assert {status["status"] for status in later()} == {"done"}


def test_a_clean_stop_leaves_no_process_and_no_shared_memory(quiet_fleet):
    # Whoever sends to a node that has just gone makes its port anew.
    used = {path for path in quiet_fleet.domain.shared_memory() if "_port" not in path.name}
    assert sum(path.exists() for path in used) >= 12
    running = [node for node in quiet_fleet.nodes.values() if node.running]
    codes = {node.name: node.stop() for node in running}

    assert len(running) == 6
    assert codes == dict.fromkeys(codes, 0)
    assert [node.name for node in running if session_members(node.pid)] == []
    assert [path for path in used if path.exists()] == []


def session_members(session_id: int) -> list[int]:
    """Pids of the processes in a session; every node of the tests leads one of its own."""
    return [p.pid for p in psutil.process_iter() if _session(p.pid) == session_id]


def _session(pid: int) -> int | None:
    try:
        return os.getsid(pid)
    except ProcessLookupError:
        return None
