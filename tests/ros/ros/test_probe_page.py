"""What a page needs of the probe: forms, all rates at once, few messages, little CPU time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import psutil
import pytest

from launcher.ros.discovery.graph_changes import GraphChanges
from launcher.ros.discovery.observer import Observer
from tests.support.probe_process import ProbeProcess, names
from tests.support.ros_domain import ros_domain, talking
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

NUMBERS = "tests.support.number_publisher"
MEASURED_S = 8.0


@pytest.fixture(scope="module")
def domain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """A domain of its own with a node that has parameters."""
    with (
        ros_domain(tmp_path_factory.mktemp("page_log")) as env,
        talking(env, "tests.support.parameter_node"),
    ):
        yield env


@pytest.fixture(scope="module")
def probe(domain: dict[str, str]) -> Iterator[ProbeProcess]:
    with ProbeProcess(domain) as probe:
        probe.graph(lambda g: g["complete"] and "/tunable" in names(g), "the node")
        probe.graph(lambda g: "/grow" in [s["name"] for s in g["services"]], "its service")
        yield probe


def described(probe: ProbeProcess) -> dict[str, dict[str, Any]]:
    found = probe.ask("describe_parameters", node="/tunable", timeout_s=60)["parameters"]
    keys = [parameter["name"] for parameter in found]
    assert keys == sorted(keys)
    return {parameter["name"]: parameter for parameter in found}


def test_parameters_are_described_with_all_that_a_form_needs(probe):
    found = described(probe)
    assert found["speed"] == {
        "name": "speed",
        "type": "double",
        "value": 0.5,
        "description": "in m/s",
        "read_only": False,
        "additional_constraints": "not 1.5",
        "integer_range": None,
        "floating_range": {"from": 0.0, "to": 2.0, "step": 0.0},
    }
    assert found["gears"]["integer_range"] == {"from": 1, "to": 9, "step": 2}
    assert (found["gears"]["type"], found["gears"]["value"]) == ("integer", 3)
    assert found["serial"]["read_only"] and not found["gears"]["read_only"]
    assert (found["bytes"]["type"], found["bytes"]["value"]) == ("byte array", [0, 255])


def test_a_parameter_without_a_value_hides_none_of_the_others(probe):
    later = described(probe)["later"]
    assert (later["type"], later["value"]) == ("integer", None)
    asked = probe.ask("get_parameters", node="/tunable", timeout_s=60)
    assert (asked["values"]["later"], asked["types"]["later"]) == (None, "not set")
    assert (asked["values"]["gears"], asked["missing"]) == (3, [])


def test_a_refused_parameter_has_the_words_of_the_node(probe):
    wanted = {"gears": 4, "serial": "B8", "speed": 1.5, "later": "text", "unknown": 1}
    results = probe.ask("set_parameters", node="/tunable", values=wanted, timeout_s=60)["results"]
    assert not any(result["successful"] for result in results.values())
    assert results["speed"]["reason"] == "1.5 m/s makes it resonate"
    assert "not a valid step" in results["gears"]["reason"]
    assert "read-only" in results["serial"]["reason"]
    assert all(result["reason"] for result in results.values())
    before = described(probe)
    assert (before["gears"]["value"], before["speed"]["value"]) == (3, 0.5)
    wanted = {"gears": 5, "speed": 1}
    results = probe.ask("set_parameters", node="/tunable", values=wanted, timeout_s=60)["results"]
    assert all(result["successful"] for result in results.values())
    assert (described(probe)["gears"]["value"], described(probe)["speed"]["value"]) == (5, 1.0)
    probe.ask("set_parameters", node="/tunable", values={"gears": 3, "speed": 0.5}, timeout_s=60)


def test_a_type_is_described_for_a_form(probe):
    found = probe.ask("form", type="std_srvs/SetBool")
    assert (found["type"], found["kind"]) == ("std_srvs/srv/SetBool", "srv")
    assert [(f["name"], f["type"], f["default"]) for f in found["request"]] == [
        ("data", "bool", False)
    ]
    error = probe.refusal("form", type="std_msgs/msg/Sting")
    assert error["message"] == "Unknown interface 'std_msgs/msg/Sting'"
    assert "std_msgs/msg/String" in error["hint"]


def test_the_newest_message_of_a_period_is_sent_with_the_number_left_out(probe, domain):
    probe.ask("subscribe", sub="some", topic="/flow", most_hz=5)
    start_s = time.monotonic()
    with talking(domain, NUMBERS, "flow", "300", "300"):
        wait_until(lambda: {"data": 299} in probe.messages("some"), "the last message")
        took_s = time.monotonic() - start_s
        assert probe.ask("rate", sub="some")["count"] == 300
        assert probe.ask("traffic")["subs"]["some"]["bytes_per_s"] > 0
    events = [x for x in probe.said if x.get("event") == "message" and x["sub"] == "some"]
    assert sum(event["skipped"] + 1 for event in events) == 300
    assert len(events) <= 5 * took_s + 2
    numbers = [event["data"]["data"] for event in events]
    assert numbers == sorted(numbers)
    probe.ask("unsubscribe", sub="some")


def test_a_message_that_cannot_be_read_says_so(probe, domain):
    with talking(domain, "tests.support.many_topics", "broken", "1", "raw"):
        probe.ask("subscribe", sub="broken", topic="/broken/t0", most_hz=5)
        event = probe.event("message", sub="broken")
    assert event["data"] is None and "deserializ" in event["error"]
    probe.ask("unsubscribe", sub="broken")


@pytest.mark.parametrize("most_hz", [0, -1, "many"])
def test_a_rate_that_is_none_is_refused(probe, most_hz):
    message = probe.refusal("subscribe", sub="x", topic="/a", most_hz=most_hz)["message"]
    assert message.startswith("'most_hz' must be")


def test_the_traffic_of_all_subscriptions_comes_at_once(probe, domain):
    with talking(domain, "tests.support.many_topics", "few", "2"):
        for number in range(2):
            probe.ask("subscribe", sub=f"t{number}", topic=f"/few/t{number}", messages=False)
        probe.ask("subscribe", sub="none", topic="/nowhere", messages=False)

        def now() -> dict[str, Any]:
            return dict(probe.ask("traffic")["subs"])

        wait_until(lambda: all(now()[f"t{n}"]["count"] >= 3 for n in range(2)), "messages")
        found = now()
    assert found["none"] == {
        "topic": "/nowhere",
        "rate_hz": 0.0,
        "bytes_per_s": 0.0,
        "age_s": None,
        "count": 0,
        "state": "waiting",
        "error": None,
    }
    assert (found["t0"]["state"], found["t0"]["topic"]) == ("subscribed", "/few/t0")
    assert 0 < found["t0"]["rate_hz"] < 5 and found["t0"]["age_s"] >= 0
    assert found["t0"]["bytes_per_s"] > 100 * found["t0"]["rate_hz"]
    for key in ("t0", "t1", "none"):
        probe.ask("unsubscribe", sub=key)


def test_the_history_of_a_latched_topic_is_no_traffic(probe, domain):
    with talking(domain, "tests.support.sample_nodes"):
        probe.ask("subscribe", sub="l", topic="/latched", messages=False)

        def now() -> dict[str, Any]:
            return dict(probe.ask("traffic")["subs"]["l"])

        wait_until(lambda: now()["count"] == 5, "the history")
        assert (now()["rate_hz"], now()["bytes_per_s"]) == (0.0, 0.0)
    probe.ask("unsubscribe", sub="l")


def test_a_topic_of_two_types_has_failed_and_says_why(domain):
    with ProbeProcess(domain) as probe, ExitStack() as both:
        both.enter_context(talking(domain, NUMBERS, "double", "1", "1"))
        both.enter_context(talking(domain, NUMBERS, "double", "1", "1", "RELIABLE", "9"))
        probe.graph(lambda g: types_of(g, "/double") == 2, "both types")
        assert probe.ask("subscribe", sub="d", topic="/double") == {"state": "waiting"}
        found = probe.ask("traffic")["subs"]["d"]
        assert found["state"] == "failed"
        assert "more than one type: std_msgs/msg/Int32, std_msgs/msg/String" in found["error"]


def types_of(graph: dict[str, Any], topic: str) -> int:
    return sum(len(t["types"]) for t in graph["topics"] if t["name"] == topic)


def test_periods_are_set_and_checked(probe):
    assert probe.ask("listen") == {"period_s": 0.01, "graph_s": 0.1}
    assert probe.ask("listen", period_s=0.05) == {"period_s": 0.05, "graph_s": 0.1}
    assert "'graph_s' must be from" in probe.refusal("listen", graph_s=0)["message"]
    assert probe.ask("listen", period_s=0.01) == {"period_s": 0.01, "graph_s": 0.1}


def test_a_change_of_the_graph_is_noticed_and_quiet_is_as_well(probe, domain):
    with Observer(int(domain["ROS_DOMAIN_ID"])) as observer:
        changes = GraphChanges(observer.node)
        wait_until(lambda: "/tunable" in observer.node_names(), "the node")
        quiet_s = time.monotonic()

        def is_quiet() -> bool:
            nonlocal quiet_s
            if changes.happened():
                quiet_s = time.monotonic()
            return time.monotonic() - quiet_s > 0.5

        wait_until(is_quiet, "half a second without a change")
        probe.ask("call", service="/grow", timeout_s=60)
        wait_until(changes.happened, "a change")
        changes.close()
    probe.graph(lambda g: publishers_of(g, "/grown") >= 2, "the new publisher")


def publishers_of(graph: dict[str, Any], topic: str) -> int:
    return sum(t["publishers"] for t in graph["topics"] if t["name"] == topic)


def test_two_hundred_topics_cost_little_cpu_time(domain):
    """4 % of a core were measured; 40 % if each of them is read every 10 ms."""
    with ExitStack() as programs:
        for name in ("left", "right"):
            programs.enter_context(talking(domain, "tests.support.many_topics", name, "100"))
        probe = programs.enter_context(ProbeProcess(domain))
        topics = [f"/{name}/t{n}" for name in ("left", "right") for n in range(100)]
        probe.graph(lambda g: set(topics) <= {t["name"] for t in g["topics"]}, "all topics")
        for topic in topics:
            probe.ask("subscribe", sub=topic, topic=topic, messages=False)

        def counts() -> list[int]:
            return [sub["count"] for sub in probe.ask("traffic")["subs"].values()]

        wait_until(lambda: min(counts()) >= 3, "messages on all topics")
        before, start_s = counts(), time.monotonic()
        start = psutil.Process(probe.pid).cpu_times()
        wait_until(lambda: time.monotonic() - start_s > MEASURED_S, "the end of the measurement")
        end = psutil.Process(probe.pid).cpu_times()
        took_s = time.monotonic() - start_s
        assert sum(counts()) - sum(before) > 0.8 * took_s * len(topics)
        assert (end.user + end.system - start.user - start.system) / took_s < 0.15
