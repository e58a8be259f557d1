"""Messages of many types, published from YAML and echoed as YAML."""

from __future__ import annotations

import pytest
import yaml

from tests.support.any_message import has
from tests.support.verbs import going_on

pytestmark = pytest.mark.thorough

MESSAGES = {
    "std_msgs/msg/ByteMultiArray": {"data": ["\0", "A", "\xff"]},
    "std_msgs/msg/UInt8MultiArray": {"data": [0, 1, 255]},
    "std_msgs/msg/Int64": {"data": -(2**63)},
    "std_msgs/msg/String": {"data": "grüße \U0001f916: [x] 'y' \"z\" # \\ \ttab"},
    "std_msgs/msg/Header": {"stamp": {"sec": -1, "nanosec": 999999999}, "frame_id": "map"},
    "shape_msgs/msg/SolidPrimitive": {"type": 2, "dimensions": [0.1, 1e-300, -0.0]},
    "sensor_msgs/msg/CameraInfo": {"k": [float(n) for n in range(9)], "d": [0.5]},
    "geometry_msgs/msg/PoseStamped": {
        "header": {"frame_id": "odom"},
        "pose": {"orientation": {"x": 0.5, "w": 0.25}},
    },
    "diagnostic_msgs/msg/DiagnosticArray": {
        "status": [
            {"level": "\x02", "name": "a", "values": [{"key": "k", "value": "1"}]},
            {"name": "b"},
        ]
    },
    "std_msgs/msg/Empty": {},
}


@pytest.mark.parametrize("name", MESSAGES)
def test_what_is_published_as_yaml_arrives_as_yaml(verb, env, name):
    values = MESSAGES[name]
    topic = f"/type_{name.rpartition('/')[2].lower()}"
    with going_on(env, "topic", "pub", topic, name, yaml.safe_dump(values), "-r", "20", "-w", "0"):
        answer = verb("topic", "echo", topic, name, "--once", "-f")
    (document, _) = yaml.safe_load_all(answer.out)
    assert has(document or {}, values), answer
