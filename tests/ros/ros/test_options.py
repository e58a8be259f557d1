"""Options of the ROS verbs that no other module covers, against real nodes."""

from __future__ import annotations

import json
import re

import pytest
import yaml

from launcher.posix.domains import PROFILES, has_profiles
from launcher.ros.discovery.observer import Observer
from tests.support.node_process import line_of
from tests.support.verbs import TIMEOUT_S, eventually, going_on, launcher
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

PUB = ("topic", "pub", "/opts", "std_msgs/msg/String", "data: hi", "-w", "0")


def endpoint_of(verb, topic: str, direction: str) -> dict[str, object]:
    """The QoS of the one endpoint that a running verb has on a topic, hidden as it is."""
    found: list[dict[str, object]] = []

    def look() -> bool:
        answer = verb("topic", "info", topic, "--json")
        known = answer.json()["endpoints"] if answer.code == 0 else []
        found[:] = [e for e in known if "_launcher_" in e["node"] and e["direction"] == direction]
        return bool(found)

    wait_until(look, f"a {direction} on {topic}")
    return found[0]


# ---- topic


def test_the_list_as_json_counts_both_sides(verb):
    listed = {topic["name"]: topic for topic in verb("topic", "list", "--json").json()["topics"]}
    assert listed["/chatter"] == {
        "name": "/chatter",
        "types": ["std_msgs/msg/String"],
        "publisher_count": 1,
        "subscription_count": 1,
    }


def test_find_counts_and_takes_hidden_topics(verb):
    words = ("topic", "find", "std_msgs/msg/String")
    assert verb(*words, "-c").out == "2\n"
    hidden = verb(*words, "--include-hidden-topics").lines
    assert hidden == ["/_secret", "/chatter", "/weak"]
    found = verb(*words, "--json").json()["topics"]
    assert [one["name"] for one in found] == ["/chatter", "/weak"]


def test_type_as_json(verb):
    assert verb("topic", "type", "chatter", "--json").json() == {
        "version": 1,
        "name": "/chatter",
        "types": ["std_msgs/msg/String"],
    }


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            ["--qos-profile", "sensor_data"],
            {"reliability": "BEST_EFFORT", "durability": "VOLATILE"},
        ),
        (
            ["--qos-reliability", "reliable", "--qos-durability", "transient_local"],
            {"reliability": "RELIABLE", "durability": "TRANSIENT_LOCAL"},
        ),
        (
            ["--qos-liveliness", "manual_by_topic", "--qos-liveliness-lease-duration-seconds", "2"],
            {"liveliness": "MANUAL_BY_TOPIC", "lease_ns": 2 * 10**9},
        ),
    ],
    ids=["preset", "policies", "liveliness"],
)
@pytest.mark.parametrize("kind", ["pub", "echo"])
def test_qos_options_are_those_of_the_endpoint(verb, env, kind, words, expected):
    command = {
        "pub": (*PUB, "-r", "1"),
        "echo": ("topic", "echo", "/opts", "std_msgs/msg/String"),
    }[kind]
    direction = {"pub": "publisher", "echo": "subscription"}[kind]
    with going_on(env, *command, *words):
        endpoint = endpoint_of(verb, "/opts", direction)
    assert {name: endpoint[name] for name in expected} == expected


@pytest.mark.parametrize(
    ("words", "numbers"),
    [(["--qos-depth", "2"], [6, 7]), (["--qos-history", "keep_all"], [3, 4, 5, 6, 7])],
    ids=["depth", "history"],
)
def test_the_queue_is_as_long_as_asked_for(verb, words, numbers):
    policies = ("--qos-reliability", "reliable", "--qos-durability", "transient_local")
    echo = ("topic", "echo", "/latched", "--csv", "--timeout", "3", *policies, *words)
    # What has come is taken from the queue meanwhile, so that a short one may have more as well.
    eventually(lambda: verb(*echo), lambda answer: [*map(int, answer.lines)] == numbers)


def test_a_bad_policy_names_those_that_exist(verb):
    answer = verb("topic", "echo", "/chatter", "--qos-durability", "eternal")
    assert (answer.code, "transient_local" in answer.err) == (2, True)


def test_lost_messages_may_be_named_as_with_ros2(verb):
    answer = verb("topic", "echo", "/chatter", "--once", "--no-lost-messages", "--no-daemon")
    assert (answer.lines[-1], answer.code) == ("---", 0)


def test_field_and_raw_exclude_each_other(verb):
    assert verb("topic", "echo", "/chatter", "--field", "data", "--raw").code == 2


@pytest.mark.parametrize("word", ["0", "-3", "many"])
def test_a_window_is_a_positive_number(verb, word):
    assert verb("topic", "hz", "/chatter", f"--window={word}").code == 2


def test_hz_looks_at_the_window_and_at_what_the_filter_lets_through(verb):
    words = ("topic", "hz", "/chatter", "--for", "3.2", "--window", "4")
    answer = eventually(lambda: verb(*words), lambda answer: "window: 4" in answer.out)
    assert max(re.findall(r"window: (\d+)", answer.out)) == "4"
    one_in_ten = (*words, "--filter", "m.data.endswith('0')", "--json")
    filtered = eventually(lambda: verb(*one_in_ten), lambda answer: messages_of(answer) > 0)
    assert messages_of(filtered) <= 6  # of about 32


def messages_of(answer) -> int:
    """As the last line counts them."""
    return json.loads(answer.lines[-1])["messages"]


def test_hz_of_several_topics_is_a_table(verb):
    words = ("topic", "hz", "/chatter", "/numbers", "--for", "3.2")
    lines = eventually(lambda: verb(*words), lambda answer: "\n/numbers" in answer.out).lines
    heads = [i for i, line in enumerate(lines) if line.split()[:2] == ["topic", "rate"]]
    rows = lines[heads[-1] + 2 :]
    assert set(lines[heads[-1] + 1]) == {"="}
    assert {row.split()[0] for row in rows if row} == {"/chatter", "/numbers"}


def test_bw_looks_at_its_window_and_has_json(verb):
    words = ("topic", "bw", "/chatter", "--for", "2.2", "-w", "5", "--json")
    answer = eventually(lambda: verb(*words), lambda answer: '"messages": 5' in answer.out)
    *rates, total = map(json.loads, answer.lines)
    assert {one["event"] for one in rates} == {"rate"} and rates[-1]["messages"] == 5
    assert total["event"] == "total" and total["messages"] > 5  # not only those of the window


def test_delay_looks_at_its_window(verb):
    words = ("topic", "delay", "/points", "--for", "2.2", "-w", "5", "--json")
    answer = eventually(lambda: verb(*words), lambda answer: '"window": 5' in answer.out)
    assert json.loads(answer.lines[-1])["window"] == 5


def test_pub_says_each_nth_and_needs_a_rate_above_zero(verb):
    words = (*PUB, "--times", "4", "--rate", "50", "--keep-alive", "0")
    said = re.findall(r"publishing #(\d)", verb(*words, "-p", "2").out)
    assert said == ["2", "4"]
    assert verb(*PUB, "--rate", "0").code == 2
    assert verb(*PUB, "--once", "--times", "3").code == 2


def test_pub_waits_for_as_many_subscriptions_as_it_is_told(verb, env):
    words = ("topic", "pub", "/waiting", "std_msgs/msg/String", "--once", "-w", "1")
    with going_on(env, *words) as program:
        waiting = "Waiting for at least 1 matching subscription(s)...\n"
        assert line_of(program.stdout) == waiting
        # RELIABLE, or the one message may come before echo knows who sends it
        words = ("/waiting", "std_msgs/msg/String", "--once", "--qos-reliability", "reliable")
        assert verb("topic", "echo", *words).code == 0
        assert program.wait(TIMEOUT_S) == 0


# ---- node


def test_node_info_with_hidden_names_and_as_json(verb):
    plain, whole = (
        {
            one["name"]
            for one in verb("node", "info", "/talker", *words, "--json").json()["publishers"]
        }
        for words in ((), ("--include-hidden",))
    )
    assert whole - plain == {"/_secret"}


def test_node_list_as_json_counts_namesakes(verb):
    assert {"name": "/twin", "count": 2} in verb("node", "list", "--json").json()["nodes"]


def test_ps_of_hidden_nodes(verb):
    nodes = {row["name"] for row in verb("node", "ps", "-a", "--json").json()["nodes"]}
    assert {"/_shy", "/talker"} <= nodes


# ---- param


def test_parameters_below_a_prefix_alone(verb):
    answer = verb("param", "list", "/talker", "--param-prefixes", "start_type_description_service")
    assert answer.code == 0
    assert answer.lines == ["  start_type_description_service"]


def test_hidden_nodes_have_parameters_as_well(verb):
    assert "/_shy:" in verb("param", "list", "--include-hidden-nodes").lines
    assert "/_shy:" not in verb("param", "list").lines


def test_parameters_as_json(verb):
    assert verb("param", "get", "/talker", "speed", "--json").json()["type"] == "double"
    described = verb("param", "describe", "/talker", "speed", "tags", "--json").json()
    assert [one["name"] for one in described["parameters"]] == ["speed", "tags"]
    dumped = verb("param", "dump", "/talker", "--json").json()
    assert {"name": "name", "type": "string", "value": "sample"} in dumped["parameters"]


def test_the_wildcard_of_a_parameter_file_is_left_out_on_request(verb, tmp_path):
    path = tmp_path / "all.yaml"
    path.write_text(
        yaml.safe_dump({"/**": {"ros__parameters": {"tags": ["c", "d"]}}}), encoding="utf-8"
    )
    assert verb("param", "load", "/talker", str(path), "--no-use-wildcard").code == 1
    assert verb("param", "get", "/talker", "tags", "--hide-type").out == "['a', 'b']\n"
    assert verb("param", "load", "/talker", str(path)).code == 0
    assert verb("param", "get", "/talker", "tags", "--hide-type").out == "['c', 'd']\n"
    assert verb("param", "set", "/talker", "tags", "[a, b]").code == 0


# ---- service


def test_services_are_counted_found_and_hidden(verb):
    names = verb("service", "list").lines
    assert verb("service", "list", "-c").out == f"{len(names)}\n"
    assert verb("service", "find", "std_srvs/srv/SetBool", "-c").out == "1\n"
    hidden = set(verb("service", "list", "--include-hidden-services").lines) - set(names)
    assert "/_shy/get_parameters" in hidden
    assert all("/_" in name for name in hidden)
    listed = verb("service", "list", "--json").json()["services"]
    assert {"name": "/switch", "types": ["std_srvs/srv/SetBool"]} in listed


def test_a_call_takes_its_request_from_stdin(verb):
    words = ("service", "call", "/switch", "std_srvs/srv/SetBool", "--stdin", "--json")
    response = {"success": True, "message": "on"}
    assert verb(*words, text="data: true").json() == {"version": 1, "response": response}


def test_calls_again_and_again(env):
    words = ("service", "call", "/switch", "std_srvs/srv/SetBool", "--rate", "20", "--json")
    with going_on(env, *words) as program:
        answers = [json.loads(line_of(program.stdout))["response"] for _ in range(3)]
        assert [one["message"] for one in answers] == ["off"] * 3
    assert program.returncode == 0


def test_a_rate_of_calls_is_above_zero(verb):
    assert verb("service", "call", "/switch", "std_srvs/srv/SetBool", "-r", "0").code == 2


# ---- interface


def test_comments_of_nested_types_come_when_asked_for(verb):
    plain, whole = (
        verb("interface", "show", "std_msgs/msg/Header", *words).out
        for words in ((), ("--all-comments",))
    )
    assert "\t# " not in plain
    assert "\t# " in whole


# ---- graph


@pytest.mark.parametrize(
    ("words", "there", "not_there"),
    [
        (["--mode", "nodes"], "/talker", "/numbers"),
        (["--mode", "all"], "/numbers", "/rosout"),
        (["--debug-topics"], "/rosout", "/_secret"),
        (["--hidden"], "/_secret", "/rosout"),
        (["--include", "weak"], "/weak", "/numbers"),
        (["--exclude", "numbers"], "/weak", "/numbers"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
@pytest.mark.parametrize("shape", [[], ["--dot"], ["--mermaid"]], ids=["tree", "dot", "mermaid"])
def test_the_graph_shows_what_is_asked_for(verb, shape, words, there, not_there):
    out = verb("graph", *shape, *words).out
    assert there in out
    assert not_there not in out


def test_shapes_of_the_graph_exclude_each_other(verb):
    assert verb("graph", "--dot", "--mermaid").code == 2


def test_a_difference_as_json_is_a_list(verb, tmp_path):
    path = tmp_path / "saved.json"
    document = verb("graph", "--json").json()
    document["nodes"].remove("/talker")
    path.write_text(json.dumps(document), encoding="utf-8")
    answer = verb("graph", "--diff", str(path), "--json")
    assert answer.code == 1
    assert answer.json()["differences"] == [{"change": "new", "text": "node /talker"}]


# ---- pub


def test_pub_has_the_node_that_it_is_told(env, verb):
    with going_on(env, "topic", "pub", "/opts", "std_msgs/msg/String", "data: a", "-n", "teller"):
        names = ("node", "info", "/teller")
        said = eventually(lambda: verb(*names), lambda answer: "/opts" in answer.out)
        assert "    /opts: std_msgs/msg/String" in said.lines
    refused = verb("topic", "pub", "/opts", "std_msgs/msg/String", "-n", "no such")
    assert (refused.code, refused.err.startswith("error: --node-name: Invalid node name")) == (
        2,
        True,
    )


def test_pub_does_not_wait_longer_than_it_is_told(verb):
    words = (
        "topic",
        "pub",
        "/alone",
        "std_msgs/msg/String",
        "data: a",
        "--max-wait-time-secs",
        "1",
    )
    answer = verb(*words, "--once")
    assert (answer.code, answer.lines[0]) == (
        1,
        "Waiting for at least 1 matching subscription(s)...",
    )
    assert answer.err == (
        "Timed out waiting for subscribers: Expected 1 subscribers but only got 0 subscribers\n"
    )
    endless = verb(*words)
    assert (endless.code, "only effective with --wait-matching-subscriptions" in endless.err) == (
        2,
        True,
    )


def test_the_profile_of_pub_is_read_and_its_own_only(env, monkeypatch):
    words = ("topic", "pub", "/profiled", "std_msgs/msg/String", "data: a", "--once", "-w", "0")
    answer = launcher(env, *words)
    assert (answer.err, answer.code) == ("", 0)  # Fast DDS complains about a file that is wrong
    for variable in PROFILES:
        monkeypatch.delenv(variable, raising=False)
    with Observer(int(env["ROS_DOMAIN_ID"]), profile="/no/such/profile.xml"):
        assert not has_profiles()
