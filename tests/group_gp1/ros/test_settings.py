"""Parameters: bad values are refused with a sentence, good ones are described."""

from __future__ import annotations

import pytest
from rcl_interfaces.srv import DescribeParameters

BAD = {
    "negative rate": ("dispatcher", "dispatch_rate_hz", "-1.0"),
    "rate of zero": ("dispatcher", "dispatch_rate_hz", "0.0"),
    "rate is no number": ("dispatcher", "dispatch_rate_hz", ".nan"),
    "rate is a text": ("dispatcher", "dispatch_rate_hz", "fast"),
    "no robots": ("dispatcher", "robot_ids", "[]"),
    "a robot twice": ("dispatcher", "robot_ids", "[robot_1,robot_1]"),
    "a robot without name": ("monitor", "robot_ids", "['']"),
    "negative timeout": ("monitor", "silence_timeout_s", "-5.0"),
    "negative grace": ("monitor", "start_grace_s", "-1.0"),
    "negative duration": ("robot_2", "task_duration_s", "-2.0"),
    "queue of depth 0": ("robot_2", "task_queue_depth", "0"),
}


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "parameter", "value"), BAD.values(), ids=BAD.keys())
def test_a_bad_value_is_refused_with_a_sentence(domain, name, parameter, value):
    node = domain.start(name, **{parameter: value})

    assert node.wait() == 1
    assert len(node.lines) == 1, node.output
    assert node.output.startswith(f"error: {name}: parameter '{parameter}' must be ")


@pytest.mark.thorough
@pytest.mark.parametrize("value", ["0", "-1", "1001", "deep"])
def test_a_bad_depth_is_refused_with_a_sentence(domain, value):
    node = domain.start("robot_1", **{"qos_overrides./fleet/status.publisher.depth": value})

    assert node.wait() == 1
    last = node.output.splitlines()[-1]
    assert last.startswith("error: ")
    assert value in last


def test_parameters_describe_type_range_and_unit(domain):
    domain.start("dispatcher")
    service = "/dispatcher/describe_parameters"
    client = domain.listener.create_client(DescribeParameters, service)
    domain.wait_until(client.service_is_ready, "the parameter service is there")
    answer = domain.ask(client, DescribeParameters.Request(names=["dispatch_rate_hz"]))
    (descriptor,) = answer.descriptors

    assert descriptor.description == "Assignments [Hz]"
    assert descriptor.read_only
    assert descriptor.floating_point_range[0].from_value == 0.01
