"""`param`, `service` and `interface` against real nodes."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import pytest
import yaml

from launcher.posix.ports import participants_by_domain
from launcher.ros.messages.message_schema import rihs_hash
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import eventually, launcher
from tests.support.waiting import rest_of, wait_until

LISTENER = "/site/east/listener"
REQUEST = "requester: making request: std_srvs.srv.Trigger_Request()"
TALKER = ["name", "speed", "start_type_description_service", "tags", "use_sim_time"]


def test_parameters_of_one_node_and_of_all(verb):
    assert verb("param", "list", "talker").lines == [f"  {name}" for name in TALKER]
    everything = verb("param", "list").lines
    assert everything[0] == "/site/east/listener:"
    assert everything[everything.index("/talker:") + 1] == "  name"


def test_the_list_with_types_and_as_json(verb):
    assert "  speed (type: double)" in verb("param", "list", "/talker", "--param-type").lines
    (node,) = verb("param", "list", "/talker", "--json").json()["nodes"]
    assert node == {"name": "/talker", "parameters": [{"name": name} for name in TALKER]}


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["speed"], "Double value is: 1.5\n"),
        (["tags"], "String values are: ['a', 'b']\n"),
        (["use_sim_time"], "Boolean value is: False\n"),
        (["name", "--hide-type"], "sample\n"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_get_has_the_words_of_ros2(verb, words, text):
    assert verb("param", "get", "/talker", *words).out == text


def test_several_parameters_of_a_node(verb):
    assert verb("param", "get", "/talker", "speed", "name").lines == [
        "speed:",
        "  Double value is: 1.5",
        "name:",
        "  String value is: sample",
    ]
    short = verb("param", "get", "/talker", "name", "nope", "sped", "--hide-type")
    assert (short.out, short.code) == ("name: sample\n", 1)
    assert short.err == (
        "Parameter(s) 'nope', 'sped' not available on node\nhint: did you mean 'speed'?\n"
    )


def test_a_parameter_of_all_nodes(verb):
    assert verb("param", "get", "speed").lines == ["/talker:", "  Double value is: 1.5"]
    everywhere = verb("param", "get", "use_sim_time", "--hide-type").lines
    assert everywhere[-2:] == ["/talker: False", "/twin: False"]
    nowhere = verb("param", "get", "/talker")
    assert (nowhere.out, nowhere.code) == ("Parameter '/talker' not set on any node\n", 0)
    assert nowhere.err == "hint: '/talker' is a node: param list /talker\n"
    (one,) = verb("param", "get", "speed", "--json").json()["parameters"]
    assert one == {"node": "/talker", "name": "speed", "type": "double", "value": 1.5}


@pytest.mark.thorough
def test_nodes_are_listed_as_they_answer_and_those_that_do_not_are_named(tmp_path):
    late = "Timed out waiting for list_parameters response from node /slow (timeout: 1.5s)\n"
    with ros_domain(tmp_path) as env, talking(env, "tests.support.lifecycle_nodes"):
        launcher(env, "lifecycle", "set", "/slow", "configure", "--timeout", "1")
        listed = eventually(
            lambda: launcher(env, "param", "list", "--service-timeout", "1.5"),
            lambda answer: answer.err == late,
        )
        nodes = [line for line in listed.lines if line.startswith("/")]
        assert (nodes, listed.code) == (["/plain:", "/pump:", "/site/stuck:"], 1)
        got = launcher(env, "param", "get", "use_sim_time", "--timeout", "2", "--hide-type")
    late = late.replace("1.5", "2.0").replace("list", "get")
    assert (got.lines[-1], got.code) == ("/site/stuck: False", 1), got
    assert got.err == f"/slow: Error: {late}"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("counts", "Integer values are: [1, 2, 3]\n"),
        ("ratios", "Double values are: [0.5, 1.0]\n"),
        ("bytes", "Byte values are: [b'\\x00', b'\\xff']\n"),
    ],
)
def test_arrays_are_printed_as_lists(verb, name, text):
    assert verb("param", "get", LISTENER, name).out == text


def test_the_list_is_filtered_by_a_regular_expression(verb):
    assert verb("param", "list", "/talker", "--filter", "s.*d$").lines == ["  speed"]
    everywhere = verb("param", "list", "--filter", "speed|counts").lines
    assert everywhere == [f"{LISTENER}:", "  counts", "/talker:", "  speed"]
    refused = verb("param", "list", "--filter", "[a")
    assert (refused.code, "'[a' is not a regular expression: " in refused.err) == (2, True), refused


def test_a_parameter_is_deleted_where_its_node_allows_it(verb):
    assert verb("param", "set", LISTENER, "spare", "1").code == 0
    assert verb("param", "delete", LISTENER, "spare").out == "Deleted parameter successfully\n"
    assert "  spare" not in verb("param", "list", LISTENER).lines
    refused = verb("param", "delete", "/talker", "speed")
    assert refused.err.startswith("Deleting parameter failed: "), refused
    unknown = verb("param", "delete", "/talker", "sped")
    assert unknown.err.endswith("hint: did you mean 'speed'?\n")
    assert (refused.code, unknown.code) == (1, 1)


def test_bytes_are_set_as_binary(verb, tmp_path):
    try:
        assert verb("param", "set", LISTENER, "bytes", "!!binary AQID").code == 0
        assert verb("param", "get", LISTENER, "bytes", "--hide-type").out == (
            "[b'\\x01', b'\\x02', b'\\x03']\n"
        )
    finally:
        path = tmp_path / "bytes.yaml"
        path.write_text(
            f"{LISTENER}: {{ros__parameters: {{bytes: [!!binary AA==, !!binary /w==]}}}}"
        )
        assert verb("param", "load", LISTENER, str(path)).code == 0
    assert verb("param", "get", LISTENER, "bytes", "--hide-type").out == "[b'\\x00', b'\\xff']\n"


def test_the_timeout_of_param_waits_for_a_node(verb):
    started = time.monotonic()
    answer = verb("param", "get", "/late", "use_sim_time", "--timeout", "1.2")
    assert (answer.code, answer.err.startswith("Node not found")) == (1, True), answer
    assert time.monotonic() - started >= 1.2


@pytest.mark.thorough
def test_a_node_that_starts_within_the_timeout_of_param_is_found(tmp_path):
    words = [sys.executable, "-m", "launcher", "param", "list", "/talker", "--timeout", "60"]
    with ros_domain(tmp_path) as env:
        domain_id = int(env["ROS_DOMAIN_ID"])
        with subprocess.Popen(words, env=env, stdout=subprocess.PIPE, text=True) as waiting:
            wait_until(lambda: participants_by_domain()[domain_id], "the verb has a participant")
            with talking(env, "tests.support.sample_nodes"):
                out, _ = rest_of(waiting)
    assert out.splitlines() == [f"  {name}" for name in TALKER]


def test_set_takes_an_integer_for_a_double_and_explains_a_refusal(verb):
    assert verb("param", "set", "/talker", "speed", "2").out == "Set parameter successful\n"
    refused = verb("param", "set", "/talker", "speed", "9")
    assert refused.err.startswith("Setting parameter failed: Parameter speed out of range")
    assert refused.code == 1
    several = verb("param", "set", "/talker", "speed", "1.5", "name", "sample")
    assert several.lines == ["speed: Set parameter successful", "name: Set parameter successful"]


def test_set_atomically(verb):
    answer = verb("param", "set", "/talker", "tags", "[a, b]", "speed", "1.5", "--atomic")
    assert answer.out == "Set parameters atomically successful\n"


def test_describe_has_the_shape_of_ros2(verb):
    assert verb("param", "describe", "/talker", "speed").out == (
        "Parameter name: speed\n"
        "  Type: double\n"
        "  Description: speed in m/s\n"
        "  Constraints:\n"
        "    Min value: 0.0\n"
        "    Max value: 2.0\n"
    )


def test_what_dump_writes_load_takes(verb, tmp_path):
    dumped = verb("param", "dump", "/talker").out
    values = yaml.safe_load(dumped)["/talker"]["ros__parameters"]
    assert (values["speed"], values["tags"]) == (1.5, ["a", "b"])
    path = tmp_path / "talker.yaml"
    path.write_text(dumped, encoding="utf-8")
    loaded = verb("param", "load", "/talker", str(path))
    assert "Set parameter speed successful" in loaded.lines
    assert loaded.code == 0  # the read-only one is as the file says


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("/other: {ros__parameters: {a: 1}}", "does not contain parameters for /talker"),
        ("/talker: {a: 1}", "expected 'ros__parameters'"),
        ("/talker: {ros__parameters: 3}", "below 'ros__parameters' of '/talker'"),
        ("/talker: [", "params.yaml:1: invalid YAML: "),
        ("/talker: {ros__parameters: {speed: [1, x]}}", "'speed' cannot hold [1, 'x']"),
    ],
    ids=["node", "shape", "content", "yaml", "value"],
)
def test_a_parameter_file_that_does_not_fit_is_reported(verb, tmp_path, text, error):
    path = tmp_path / "params.yaml"
    path.write_text(text, encoding="utf-8")
    answer = verb("param", "load", "/talker", str(path))
    assert (answer.code, error in answer.err) == (1, True), answer


def test_a_parameter_that_is_not_declared_does_not_keep_the_others_from_being_set(verb, tmp_path):
    path = tmp_path / "params.yaml"
    path.write_text("/talker: {ros__parameters: {nope: 3, speed: 1}}", encoding="utf-8")
    answer = verb("param", "load", "/talker", str(path))
    assert answer.out == "Set parameter speed successful\n"  # where a double is declared
    assert answer.err.startswith("Set parameter nope failed: Invalid access to undeclared")
    assert answer.code == 1
    several = verb("param", "set", "/talker", "nope", "3", "speed", "1.5")
    assert (several.out, several.code) == ("speed: Set parameter successful\n", 1)


def test_what_cannot_be_a_parameter_does_not_keep_the_others_from_being_set(verb, tmp_path):
    words = ["bytes", "[1, 256]", "ratios", "[1e-9, 0.0]", "counts", "[0x10, 010]"]
    answer = verb("param", "set", LISTENER, *words)
    assert answer.lines == [f"{name}: Set parameter successful" for name in ("ratios", "counts")]
    assert answer.err == (
        "bytes: Setting parameter failed: Parameter 'bytes' cannot hold [1, 256] "
        "(a byte is from 0 to 255)\n"
    )
    assert answer.code == 1
    path = tmp_path / "params.yaml"
    path.write_text(
        f"{LISTENER}: {{ros__parameters: {{bytes: [1, a], ratios: [.5, 1e0], counts: [1, 2, 3]}}}}"
    )
    loaded = verb("param", "load", LISTENER, str(path))
    assert loaded.lines == [f"Set parameter {name} successful" for name in ("ratios", "counts")]
    assert loaded.err.startswith(
        "Set parameter bytes failed: Parameter 'bytes' cannot hold [1, 'a'"
    )
    assert loaded.code == 1
    held = verb("param", "get", LISTENER, "ratios")
    assert held.out == "Double values are: [0.5, 1.0]\n"


@pytest.mark.parametrize(
    ("words", "error", "code"),
    [
        (["get", "bad name!", "speed"], "Node not found\n", 1),
        (["set", "/talker", "name", "a\udcff"], "error: not UTF-8: 'a\\udcff'\n", 2),
        (
            ["set", "/talker", "use_sim_time", "9" * 20],
            "Setting parameter failed: Wrong parameter type",
            1,
        ),
        (["get", "/tolker", "speed"], "Node not found\nhint: did you mean '/talker'?\n", 1),
        (
            ["get", "/talker", "sped"],
            "Parameter 'sped' not found on node '/talker'\nhint: did you mean 'speed'?\n",
            1,
        ),
        (["set", "/talker", "speed"], "error: VALUE is missing after 'speed'", 2),
    ],
    ids=["name", "text", "number", "node", "parameter", "value"],
)
def test_param_errors(verb, words, error, code):
    answer = verb("param", *words)
    assert (answer.err.startswith(error), answer.code) == (True, code), answer


def test_services_are_listed_found_and_typed(verb):
    lines = verb("service", "list", "-t").lines
    assert "/switch [std_srvs/srv/SetBool]" in lines
    assert not any("observer" in line for line in lines)
    assert verb("service", "type", "/switch").out == "std_srvs/srv/SetBool\n"
    assert verb("service", "find", "std_srvs/srv/SetBool").out == "/switch\n"
    assert verb("service", "type", "/nosuch").code == 1


def test_a_call_prints_request_and_response_as_ros2_does(verb):
    answer = verb("service", "call", "/switch", "std_srvs/srv/SetBool", "data: true")
    assert answer.out == (
        "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n"
        "response:\nstd_srvs.srv.SetBool_Response(success=True, message='on')\n\n"
    )


def test_a_call_as_json(verb):
    answer = verb("service", "call", "/switch", "std_srvs/SetBool", "--json")
    assert json.loads(answer.out)["response"] == {"success": False, "message": "off"}


def test_a_call_as_json_that_waits_for_its_service_says_so_on_stderr(env, tmp_path):
    words = ("service", "call", "/nobody", "std_srvs/srv/Trigger", "--json")
    files = [tmp_path / name for name in ("out", "err")]
    with files[0].open("w") as out, files[1].open("w") as err:
        command = [sys.executable, "-m", "launcher", *words]
        with subprocess.Popen(command, env=env, stdout=out, stderr=err) as call:
            try:
                said = "waiting for service to become available...\n"
                wait_until(lambda: said in "".join(file.read_text() for file in files), said)
            finally:
                call.kill()
    assert said not in files[0].read_text()


@pytest.mark.parametrize("option", [[], ["--json"]], ids=["text", "json"])
def test_the_timeout_of_a_call_limits_the_wait_for_the_service(verb, option):
    started = time.monotonic()
    answer = verb("service", "call", "/nobody", "std_srvs/Trigger", "--timeout", "1.5", *option)
    assert (answer.code, time.monotonic() - started >= 1.5) == (1, True), answer
    assert answer.err.endswith("service '/nobody' is not available after 1.5 s\n"), answer


@pytest.mark.thorough
def test_the_timeout_of_a_call_limits_the_wait_for_the_response(env):
    words = ("service", "call", "/occupy", "std_srvs/srv/Trigger", "--timeout", "1")
    late = "Timed out waiting for response from service /occupy (timeout: 1.0s)\n"
    answer = eventually(lambda: launcher(env, *words), lambda answer: late in answer.err)
    assert (answer.code, answer.lines[0]) == (1, REQUEST), answer


@pytest.mark.thorough
def test_the_qos_of_a_call(env):
    words = ("service", "call", "/switch", "std_srvs/srv/SetBool")
    answer = launcher(env, *words, "--qos-durability", "volatile", "--qos-depth", "2")
    assert answer.code == 0, answer
    # its requests are not offered as the service asks for them
    refused = launcher(env, *words, "--qos-reliability", "best_effort", "--timeout", "4")
    assert refused.code == 1
    assert refused.err == (
        "QoS: 1 of 1 pair of client and server does not match\n"
        "  /talker receives no requests from this command\n"
        "    RELIABILITY: the client offers BEST_EFFORT, the server asks for RELIABLE\n"
        "    to repair: set the server's reliability to BEST_EFFORT, or the client's to RELIABLE\n"
        "service '/switch' is there, but its QoS does not match: waited 4 s\n"
    )


def test_the_clients_and_servers_of_a_service(verb):
    plain = verb("service", "info", "/switch", "--spin-time", "60")
    assert plain.lines == ["Type: std_srvs/srv/SetBool", "Clients count: 0", "Services count: 1"]
    lines = verb("service", "info", "/switch", "-v", "--spin-time", "60").lines
    assert lines[:3] == plain.lines
    assert lines[3:7] == [
        "Node name: talker",
        "Node namespace: /",
        "Service type: std_srvs/srv/SetBool",
        f"Service type hash: {rihs_hash('std_srvs/srv/SetBool')}",
    ]
    assert lines[7:9] == ["Endpoint type: SERVER", "Endpoint count: 2"]
    assert lines[-1] == ""


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["std_srvs/srv/SetBol"], "did you mean SetBool?"),
        (["std_msgs/msg/String"], "hint: std_msgs/msg/String is a message, not a service\n"),
        (["std_srvs/srv/SetBool", "data: 3"], "'data' takes true or false, got 3"),
        (["std_srvs/srv/Trigger"], "has the type std_srvs/srv/SetBool, not std_srvs/srv/Trigger"),
    ],
    ids=["unknown", "kind", "value", "other"],
)
def test_call_errors(verb, words, error):
    answer = verb("service", "call", "/switch", *words)
    assert (answer.code, error in answer.err) == (1, True), answer


def test_a_name_that_no_service_can_have(verb):
    answer = verb("service", "call", "bad name!", "std_srvs/srv/SetBool")
    assert (answer.err.startswith("Invalid service name: "), answer.code) == (True, 1), answer


def test_interfaces_are_listed_by_kind(verb):
    lines = verb("interface", "list", "-m").lines
    assert lines[0] == "Messages:"
    assert "    std_msgs/msg/String" in lines


def test_a_definition_shows_what_it_is_made_of(verb):
    answer = verb("interface", "show", "std_msgs/msg/Header", "--no-comments")
    assert answer.out == (
        "builtin_interfaces/Time stamp\n\tint32 sec\n\tuint32 nanosec\nstring frame_id\n"
    )
    assert verb("interface", "show", "std_msgs/msg/Empty").out == ""
    whole = verb("interface", "show", "-", text="std_srvs/srv/SetBool\n")
    assert "---" in whole.lines


def test_a_prototype_can_be_filled_in(verb):
    assert verb("interface", "proto", "geometry_msgs/msg/Point").out == (
        '"x: 0.0\ny: 0.0\nz: 0.0\n"\n'
    )


def test_an_unknown_interface_has_a_near_miss(verb):
    err = verb("interface", "show", "std_msgs/msg/Strnig").err
    assert "did you mean 'std_msgs/msg/String'?" in err
