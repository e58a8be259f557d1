"""The probe against real nodes: graph, subscriptions, calls, publishing; it stays invisible."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import psutil
import pytest

from launcher.ros.discovery.discovery_reader import read_graph
from launcher.run.monitor.shared_memory import FOLDER, held
from tests.support.drawing import CAN_DRAW, HOW_TO_DRAW, is_drawn
from tests.support.node_process import line_of
from tests.support.probe_process import ProbeProcess, names
from tests.support.ros_domain import talking
from tests.support.waiting import wait_until

NUMBERS = "tests.support.number_publisher"
SAMPLE = {"/talker", "/site/east/listener", "/twin", "/_shy"}


@pytest.fixture(scope="module")
def probe(env: dict[str, str]) -> Iterator[ProbeProcess]:
    """A probe that knows the sample nodes, and every endpoint and service that they have."""
    seen = read_graph(int(env["ROS_DOMAIN_ID"]), 60.0, remote=False)
    assert seen.missing == 0
    gids = {endpoint.gid for endpoint in seen.snapshot.topic_graph().endpoints}

    def has_all(graph: dict[str, Any]) -> bool:
        # names, publishers and subscriptions of a participant come in streams of their own
        return (
            graph["complete"]
            and names(graph) >= SAMPLE
            and gids <= {endpoint["gid"] for endpoint in graph["endpoints"]}
            and {"/switch", "/occupy"} <= {service["name"] for service in graph["services"]}
        )

    with ProbeProcess(env) as probe:
        probe.graph(has_all, "the sample nodes with all that they have")
        yield probe


def test_the_first_line_says_who_it_is(probe, env):
    ready = probe.said[0]
    assert (ready["event"], ready["protocol"], ready["pid"]) == ("ready", 1, probe.pid)
    assert ready["domain_id"] == int(env["ROS_DOMAIN_ID"])


def test_the_graph_has_nodes_processes_topics_services_and_qos(probe):
    graph = probe.ask("graph")
    nodes = {node["name"]: node for node in graph["nodes"]}
    talker = nodes["/talker"]["pid"]
    assert "tests.support.sample_nodes" in psutil.Process(talker).cmdline()
    assert nodes["/twin"] == {
        "name": "/twin",
        "hidden": False,
        "ghost": False,
        "pid": talker,
        "count": 2,
    }
    assert nodes["/_shy"]["hidden"]
    topics = {topic["name"]: topic for topic in graph["topics"]}
    assert topics["/weak"] == {
        "name": "/weak",
        "types": ["std_msgs/msg/String"],
        "publishers": 1,
        "subscriptions": 1,
    }
    assert {"name": "/switch", "types": ["std_srvs/srv/SetBool"]} in graph["services"]
    assert not [s for s in graph["services"] if s["name"].endswith("/get_parameters")]
    latched = next(e for e in graph["endpoints"] if e["topic"] == "/latched")
    assert (latched["durability"], latched["direction"]) == ("TRANSIENT_LOCAL", "publisher")
    mismatch = next(m for m in graph["mismatches"] if m["topic"] == "/weak")
    assert mismatch["subscription"] == "/site/east/listener"
    assert mismatch["policies"][0]["policy"] == "RELIABILITY"


def test_neither_the_probe_nor_other_tools_of_ours_are_part_of_the_graph(probe, env, observer):
    probe.ask("subscribe", sub="hidden", topic="/chatter", messages=False)
    probe.ask("get_parameters", node="/talker")
    probe.ask("publish", topic="/chatter", values={"data": "from the probe"})
    graph = probe.ask("graph")
    assert not [n for n in graph["nodes"] if "_launcher" in n["name"]]
    assert not [e for e in graph["endpoints"] if "_launcher" in e["node"]]
    chatter = next(t for t in graph["topics"] if t["name"] == "/chatter")
    assert (chatter["publishers"], chatter["subscriptions"]) == (1, 1)
    probe.ask("unsubscribe", sub="hidden")

    # what others see of it: hidden names, no services, nothing on /rosout
    def ours_of() -> list[str]:
        seen = observer.node.get_node_names_and_namespaces()
        return [name for name, _ in seen if f"_{probe.pid}_" in name]

    wait_until(ours_of, "its names have come")
    ours = ours_of()
    assert all(name.startswith("_") for name in ours)
    assert not any(observer.services_of(f"/{name}") for name in ours)
    rosout = observer.node.get_publishers_info_by_topic("/rosout")
    assert not [info for info in rosout if info.node_name in ours]


def test_a_fitted_subscription_gets_the_backlog_of_a_latched_topic(probe):
    assert probe.ask("subscribe", sub="latched", topic="latched") == {"state": "subscribed"}
    subscribed = probe.event("subscribed", sub="latched")
    assert subscribed["qos"]["durability"] == "TRANSIENT_LOCAL"
    assert (subscribed["type"], subscribed["fitted"]) == ("std_msgs/msg/Int32", True)
    wait_until(lambda: len(probe.messages("latched")) == 5, "the backlog")
    assert probe.messages("latched") == [{"data": number} for number in range(3, 8)]
    message = probe.event("message", sub="latched")
    assert message["sent"] < message["wall"]
    assert (
        abs((message["wall"] - message["mono"]) - (probe.said[0]["wall"] - probe.said[0]["mono"]))
        < 1
    )
    probe.ask("unsubscribe", sub="latched")


def test_an_exact_subscription_that_cannot_match_says_why_and_hears_nothing(probe):
    probe.ask("subscribe", sub="exact", topic="/weak", qos={"reliability": "RELIABLE"})
    mismatch = probe.event("mismatch", sub="exact")
    assert mismatch["policies"] == ["RELIABILITY"]
    assert "this subscription receives nothing from /talker" in mismatch["text"]
    probe.ask("subscribe", sub="fitted", topic="/weak")
    wait_until(lambda: len(probe.messages("fitted")) >= 3, "messages of the weak topic")
    assert probe.messages("exact") == []
    assert probe.ask("rate", sub="exact")["rate_hz"] == 0.0
    for key in ("exact", "fitted"):
        probe.ask("unsubscribe", sub=key)


@pytest.mark.thorough
def test_a_fitted_subscription_becomes_weaker_for_a_weaker_publisher(env):
    """With what the first publisher offers, the second would not be heard."""
    with ProbeProcess(env) as probe:
        probe.ask("subscribe", sub="s", topic="/mixed")
        with talking(env, NUMBERS, "mixed", "1", "1"):
            first = probe.event("subscribed", sub="s", again=False)
            assert first["qos"]["reliability"] == "RELIABLE"
            wait_until(lambda: probe.messages("s") == [{"data": 0}], "the stronger publisher")
            with talking(env, NUMBERS, "mixed", "1000", "20", "BEST_EFFORT"):
                again = probe.event("subscribed", sub="s", again=True)
                assert again["qos"]["reliability"] == "BEST_EFFORT"
                wait_until(lambda: len(probe.messages("s")) >= 2, "the weaker publisher, too")


def test_a_subscription_waits_for_its_topic(probe, env):
    assert probe.ask("subscribe", sub="later", topic="/fast") == {"state": "waiting"}
    with talking(env, NUMBERS, "fast", "100", "1000"):
        wait_until(lambda: len(probe.messages("later")) == 100, "all messages")
    probe.ask("unsubscribe", sub="later")


@pytest.mark.parametrize(
    ("do", "fields", "message"),
    [
        ("subscribe", {"sub": "x"}, "'topic' must be a text, got null"),
        ("subscribe", {"sub": "x", "topic": "/a b"}, "Invalid topic name"),
        ("subscribe", {"sub": "x", "topic": "/a", "type": "std_msgs/Strin"}, "invalid"),
        (
            "subscribe",
            {"sub": "x", "topic": "/a", "qos": {"reliability": "SURE"}},
            "unknown reliability 'SURE'",
        ),
        ("subscribe", {"sub": "x", "topic": "/a", "qos": {"speed": "1"}}, "unknown QoS policy"),
        ("subscribe", {"sub": "x", "topic": "/a", "stamps": True}, "needs 'messages': false"),
        ("rate", {"sub": "nobody"}, "unknown subscription 'nobody'"),
        ("subscibe", {}, "unknown request 'subscibe'"),
        ("explain", {"topic": "/weak", "as": {"direction": "up"}}, "unknown direction 'up'"),
        ("get_parameters", {"node": "/nobody"}, "is not available"),
        ("call", {"service": "/nobody", "timeout_s": 0.1}, "is not available"),
        ("call", {"service": "/switch", "type": "std_srvs/srv/Trigger"}, "has the type std_srvs"),
        ("call", {"service": "/switch", "values": {"data": 5}}, "takes true or false"),
        ("publish", {"topic": "/nowhere", "timeout_s": 0.1}, "unknown type"),
        ("publish", {"topic": "/chatter", "values": "data: [", "timeout_s": 1}, "is not YAML"),
        ("draw", {"json": "/nowhere/graph.json"}, "No such file"),
    ],
)
def test_a_request_that_cannot_be_met_is_refused_in_words(probe, do, fields, message):
    assert message in probe.refusal(do, **fields)["message"]


def test_what_is_no_request_is_refused_without_an_id(probe):
    probe.send_line("[1, 2]")
    assert probe.answer(None)["error"]["message"] == "a request is a JSON object"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("[" * 100_000, "deep"),
        ('{"id": 7, "do": "listen", "period_s": 1e999}', "1e999 is too large"),
        ('{"id": NaN, "do": "clock"}', "NaN is not JSON"),
        ('{"id": ' + "1" * 5000 + "}", "is too large"),
        ('{"do": "explain", "topic": "/\\udcff"}', "not UTF-8"),
        ('{"do": "form", "type": "\\udcff"}', "\ufffd"),
    ],
    ids=lambda text: text[:20],
)
def test_what_is_no_json_is_refused_and_the_next_request_is_answered(probe, line, message):
    probe.send_line(line)
    probe.wait_for(lambda said: message in str(said.get("error")), message)
    assert probe.ask("clock")["wall"] > 0


def test_parameters_are_read_and_set(probe):
    asked = probe.ask("get_parameters", node="/talker", names=["speed", "tags", "nothing"])
    assert asked == {
        "values": {"speed": 1.5, "tags": ["a", "b"]},
        "types": {"speed": "double", "tags": "string array"},
        "missing": ["nothing"],
    }
    # a whole number for a double, and one that is out of range
    results = probe.ask("set_parameters", node="/talker", values={"speed": 2})["results"]
    assert results["speed"]["successful"]
    results = probe.ask("set_parameters", node="/talker", values={"speed": 9.0})["results"]
    assert not results["speed"]["successful"] and results["speed"]["reason"]
    assert probe.ask("get_parameters", node="talker")["values"]["speed"] == 2.0
    results = probe.ask("set_parameters", node="/talker", values={"speed": 1, "tags": {"a": 1}})
    assert results["results"]["speed"]["successful"]
    assert results["results"]["tags"]["reason"].startswith("Parameter 'tags' cannot hold {'a': 1}")
    probe.ask("set_parameters", node="/talker", values={"speed": 1.5})


def test_a_service_that_every_node_has_can_be_called_too(probe):
    answer = probe.ask("call", service="/talker/list_parameters")
    assert "speed" in answer["values"]["result"]["names"]


def test_a_service_answers_and_one_that_is_busy_holds_up_nothing_else(probe):
    answer = probe.ask("call", service="/switch", values={"data": True})
    assert (answer["type"], answer["values"]) == (
        "std_srvs/srv/SetBool",
        {"success": True, "message": "on"},
    )
    number = probe.send("call", service="/occupy", timeout_s=2)
    before = probe.ask("clock")["mono"]
    refused = probe.answer(number)
    assert "did not answer within" in refused["error"]["message"]
    lines = [line for line in probe.said if line.get("id")]
    assert lines.index(refused) == len(lines) - 1  # the clock's answer did not wait for it
    assert before <= probe.ask("clock")["mono"]


def test_published_messages_arrive_and_incompatible_subscribers_are_named(probe, env):
    with ProbeProcess(env) as other:
        other.ask("subscribe", sub="s", topic="/said", type="std_msgs/String", qos={})
        answer = probe.ask(
            "publish",
            topic="/said",
            type="std_msgs/String",
            values="data: 'yes'",
            times=2,
            timeout_s=60,
        )
        assert (answer["published"], answer["matched"]) == (2, 1)
        wait_until(lambda: len(other.messages("s")) == 2, "both messages")
        error = probe.refusal(
            "publish",
            topic="/weak",
            values={"data": "x"},
            qos={"reliability": "BEST_EFFORT"},
            timeout_s=0.3,
        )
    assert error["message"] == "0 of 1 subscriptions on '/weak' match"
    assert "RELIABILITY: the publisher offers BEST_EFFORT" in error["hint"]


def test_rates_come_from_the_times_of_reception(probe):
    probe.ask("subscribe", sub="rate", topic="/numbers", messages=False)
    wait_until(lambda: probe.ask("rate", sub="rate")["count"] >= 12, "some messages")
    found = probe.ask("rate", sub="rate")
    found = probe.ask("rate", sub="rate", until=found["last"])  # since then it may be silent
    rate = (found["count"] - 1) / (found["last"] - found["first"])
    assert found["complete"] and found["rate_hz"] == pytest.approx(rate)
    assert found["min_s"] <= found["mean_s"] <= found["max_s"]
    assert found["bytes_mean"] > 200 * 8  # doubles
    window = probe.ask("rate", sub="rate", **{"from": found["first"], "until": found["first"]})
    assert (window["count"], window["rate_hz"]) == (1, 0.0)
    assert not probe.messages("rate")
    probe.ask("unsubscribe", sub="rate")


def test_arrivals_are_given_once_with_the_stamps_of_types_that_have_them(probe):
    for topic in ("points", "numbers", "latched"):
        probe.ask("subscribe", sub=topic, topic=f"/{topic}", messages=False, stamps=True)
    found: list[dict[str, Any]] = []

    def come(topic: str) -> list[float]:
        return [at_s for one in found for at_s in one[topic]["mono"]]

    def has_come() -> bool:
        found.append(probe.ask("arrivals")["subs"])
        return all(len(come(topic)) >= 8 for topic in ("points", "numbers"))

    wait_until(has_come, "eight messages of both")
    assert come("points") == sorted(set(come("points")))
    offset_s = probe.said[0]["wall"] - probe.said[0]["mono"]
    for one in found:
        points = one["points"]
        for mono, sent, stamp in zip(
            *(points[name] for name in ("mono", "sent", "stamp")), strict=True
        ):
            assert stamp <= sent <= mono + offset_s + 1
            assert mono + offset_s - stamp < 60
        assert one["numbers"]["stamp"] is None
    latched = found[-1]["latched"]  # has its history only
    assert (come("latched"), latched["count"], latched["state"]) == ([], 5, "subscribed")
    assert probe.ask("rate", sub="points")["count"] >= len(come("points"))
    for topic in ("points", "numbers", "latched"):
        probe.ask("unsubscribe", sub=topic)


def test_a_planned_endpoint_is_compared_with_the_existing_ones(probe):
    would = {"direction": "subscription", "qos": {"durability": "TRANSIENT_LOCAL"}}
    found = probe.ask("explain", topic="/chatter", **{"as": would})
    assert "the expectation receives nothing from /talker" in found["text"]
    assert [p["policy"] for m in found["mismatches"] for p in m["policies"]] == ["DURABILITY"]
    assert "/site/east/listener receives nothing" in probe.ask("explain", topic="/weak")["text"]


def test_the_graph_is_written_as_data_and_as_a_drawing(probe, tmp_path, verb):
    saved, drawn = tmp_path / "graph.json", tmp_path / "graph.svg"
    answer = probe.ask("draw", json=str(saved), svg=str(drawn))
    if CAN_DRAW:
        assert answer == {"json": str(saved), "svg": str(drawn), "notes": []}
    else:
        assert (answer["svg"], HOW_TO_DRAW in answer["notes"][0]) == (None, True)
    assert is_drawn(drawn, "/talker")
    assert "+ " not in verb("graph", "--diff", str(saved)).out


def test_a_killed_node_is_a_ghost_at_once_and_one_that_comes_again_is_not(env):
    with ProbeProcess(env) as probe:
        with talking(env, NUMBERS, "fast", "1", "1") as program:
            probe.graph(lambda g: publishers_of(g, "/fast") == 1, "its publisher")
            program.kill()
            program.wait()
            gone = probe.graph(lambda g: any(n["ghost"] for n in g["nodes"]), "its ghost")
            assert [n["name"] for n in gone["nodes"] if n["ghost"]] == ["/fast"]
            assert publishers_of(gone, "/fast") == 0
        probe.said.clear()
        with talking(env, NUMBERS, "fast", "1", "1"):
            back = probe.graph(lambda g: publishers_of(g, "/fast") == 1, "its publisher again")
            assert "/fast" in names(back)


def publishers_of(graph: dict[str, Any], topic: str) -> int:
    """Living ones."""
    return sum(t["publishers"] for t in graph["topics"] if t["name"] == topic)


@pytest.mark.thorough
def test_five_thousand_messages_a_second_all_arrive_in_order(env):
    count = 10_000
    with ProbeProcess(env) as probe:
        probe.ask("subscribe", sub="fast", topic="/fast", depth=count)
        with talking(env, NUMBERS, "fast", str(count), "5000"):
            wait_until(lambda: len(probe.messages("fast")) >= count, "all messages", 60)
            found = probe.ask("rate", sub="fast")
        assert probe.messages("fast") == [{"data": number} for number in range(count)]
        assert (found["count"], found["complete"]) == (count, True)


@pytest.mark.thorough
def test_a_slow_reader_costs_bounded_memory_and_gets_the_number_of_dropped_messages(env):
    """Four times the limit is published meanwhile; the publisher does not wait for the probe."""
    count = 2000
    with ProbeProcess(env, reads=False) as probe:
        # A full queue is twice the limit: however late it is taken from there, some are dropped.
        probe.send("subscribe", sub="flood", topic="/flood", depth=count // 2)
        with talking(env, NUMBERS, "flood", str(count), "500", "RELIABLE", "32768") as program:
            assert float(line_of(program.stdout)) > 0  # all published while nobody read
            used_bytes = psutil.Process(probe.pid).memory_info().rss
            probe.begin_to_read()
            missed = probe.event("dropped")["messages"]
        assert probe.ask("clock")
        assert 0 < missed < count
        assert len(probe.messages("flood")) + missed <= count
        assert used_bytes < 200 * 2**20


def test_the_probe_ends_with_its_input_even_during_a_pending_call(env):
    probe = ProbeProcess(env)
    probe.graph(lambda graph: names(graph) >= SAMPLE, "the sample nodes")
    probe.send("call", service="/nobody", timeout_s=600)
    probe.send("call", service="/occupy", timeout_s=600)
    probe.ask("clock")
    files = {f"{FOLDER}/{name}" for name, pid in held().items() if pid == probe.pid}
    files = {path for path in files if "_port" not in path}
    assert files
    assert probe.end() == (0, "")
    assert not [path for path in files if os.path.exists(path)]


def test_signals_for_the_system_are_not_for_the_probe(env):
    probe = ProbeProcess(env)
    probe.event("ready")
    for signum in (signal.SIGINT, signal.SIGHUP):
        probe.signal(signum)
    assert probe.ask("clock")
    probe.signal(signal.SIGTERM)
    assert probe.wait() == (0, "")


@pytest.mark.thorough
def test_it_ends_when_nobody_can_read_it(env):
    read, write = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-m", "launcher.ros.probe"],
        env=env,
        stdin=subprocess.PIPE,
        stdout=write,
    )
    os.close(write)
    os.read(read, 1)
    os.close(read)
    assert process.stdin is not None
    process.stdin.write(b'{"id": 1, "do": "clock"}\n')
    process.stdin.flush()
    assert process.wait(60) == 0
    process.stdin.close()
