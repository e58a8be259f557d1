"""Fields and output formats of `topic echo`."""

from __future__ import annotations

import json
import math

import pytest
from geometry_msgs.msg import Point, Pose, PoseArray
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.to_yaml import Style
from launcher.ros.topics.echo import Writer, field_of
from launcher.ros.topics.listener import ReceivedMessage
from launcher.ros.verb import print_json

POSES = PoseArray(poses=[Pose(position=Point(x=float(n))) for n in range(3)])
INFO = {
    "source_timestamp": 1,
    "received_timestamp": 2,
    "publication_sequence_number": 3,
    "reception_sequence_number": None,
}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("poses[1].position.x", 1.0),
        ("poses[-1].position.x", 2.0),
        ("poses[0].position", Point()),
        ("poses.[1].position.x", 1.0),
        ("poses.[0].position", Point()),
        ("header.frame_id", ""),
    ],
)
def test_a_field_may_be_in_a_list(path: str, value: object):
    assert field_of(POSES, path) == value


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("poses.[7].position", "list index out of range\nhint: it has 3 values"),
        ("poses[7]", "list index out of range\nhint: it has 3 values"),
        ("poses[a]", "invalid literal"),
        ("poses[0", "invalid literal"),
        ("poses.x", "'list' object has no attribute 'x'\nhint: it has 3 values"),
        ("header[0]", "'Header' object is not subscriptable\nhint: fields: stamp, frame_id"),
        ("pose", "'PoseArray' object has no attribute 'pose'\nhint: fields: header, poses"),
    ],
)
def test_an_unknown_field_is_reported_with_the_existing_ones(path: str, reason: str):
    with pytest.raises(VerbError) as caught:
        field_of(POSES, path)
    assert caught.value.render().startswith(f"Invalid field '{path}': ")
    assert reason in caught.value.render()


def written(message: object, *fields: str, info: bool = True, **options: bool) -> str:
    sample = ReceivedMessage(topic="/t", message=message, info=INFO)
    writer = Writer(style=Style(), info=info, fields=fields, **options)
    return "".join(writer.pieces(sample, writer.values(sample)))


def test_times_and_numbers_come_before_a_message_in_each_shape():
    assert written(Float64(data=1.0)).startswith("publication_sequence_number: 3\n")
    assert written(Float64(data=1.0), csv=True) == "1,2,3,None,1.0\n"
    assert written(b"ab", raw=True) == (
        f"---Got new message, message info:---\n{INFO}\n---Message data:---\nb'ab'\n---\n"
    )


FIELDS = ("poses[1].position", "header.frame_id", "poses[2].position.x")


def test_several_fields_are_printed_one_after_another():
    whole = "x: 1.0\ny: 0.0\nz: 0.0\n\n2.0\n---\n"
    assert written(POSES, *FIELDS, info=False) == whole
    assert written(POSES, *FIELDS).count("source_timestamp") == 1
    assert written(POSES, *FIELDS).endswith("---\n" + whole)
    assert written(POSES, *FIELDS, csv=True, info=False) == "1.0,0.0,0.0\n\n2.0\n"
    assert written(POSES, "header.frame_id", FIELDS[2], csv=True) == "1,2,3,None,\n1,2,3,None,2.0\n"


def test_several_fields_are_an_object_in_json():
    document = json.loads(written(POSES, *FIELDS, json=True))
    position = {"x": 1.0, "y": 0.0, "z": 0.0}
    assert document["message"] == dict(zip(FIELDS, (position, "", 2.0), strict=True))


def test_nan_and_inf_have_no_json_form(capsys: pytest.CaptureFixture[str]):
    def strict(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    numbers = [1.5, math.nan, math.inf, -math.inf]
    print_json({"a": numbers, "b": {"c": math.nan}})
    texts = [1.5, "nan", "inf", "-inf"]
    found = json.loads(capsys.readouterr().out, parse_constant=strict)
    assert found == {"version": 1, "a": texts, "b": {"c": "nan"}}
    line = written(LaserScan(ranges=numbers), json=True)
    assert json.loads(line, parse_constant=strict)["message"]["ranges"] == texts
