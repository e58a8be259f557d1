"""What `tf echo` prints, as tf2_echo does."""

from __future__ import annotations

import json
import math

from launcher.ros.tf.arithmetic import Transform, quaternion
from launcher.ros.tf.frame_buffer import StampedTransform, TransformBuffer
from launcher.ros.tf.tf_echo import TfEcho, TfEchoOptions

S = 1_000_000_000
OPTIONS = {"frame": "map", "other": "base", "period_s": 0.5, "time_ns": 0, "digits": 3}


def echo_of(buffer: TransformBuffer, *, is_json: bool = False, **options: object) -> TfEcho:
    return TfEcho(buffer, TfEchoOptions(**{**OPTIONS, **options}, json=is_json))


def fill(buffer: TransformBuffer, stamp_ns: int, x: float = 1.0, child: str = "base") -> None:
    turned = Transform((x, 2.0, -3.0), quaternion(0.0, 0.0, math.pi / 2))
    buffer.add(StampedTransform("map", child, stamp_ns, turned), is_static=False)


def test_the_text_is_that_of_tf2_echo(capsys):
    buffer = TransformBuffer()
    fill(buffer, 12 * S + 45)

    echo_of(buffer).step(0, 0.0)

    assert (
        capsys.readouterr().out
        == """\
At time 12.000000045
- Translation: [1.000, 2.000, -3.000]
- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.707, 0.707]
- Rotation: in RPY (radian) [0.000, -0.000, 1.571]
- Rotation: in RPY (degree) [0.000, -0.000, 90.000]
- Matrix:
  0.000 -1.000  0.000  1.000
  1.000  0.000  0.000  2.000
  0.000  0.000  1.000 -3.000
  0.000  0.000  0.000  1.000
"""
    )


def test_digits(capsys):
    buffer = TransformBuffer()
    fill(buffer, S)

    echo_of(buffer, digits=0).step(0, 0.0)

    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "- Translation: [1, 2, -3]"
    assert lines[-1] == "      0      0      0      1"


def test_it_waits_and_says_why_once_a_second(capsys):
    buffer = TransformBuffer()
    echo = echo_of(buffer)
    for number in range(25):
        echo.step(7 * S, number / 10)

    why = 'Invalid frame ID "map" passed to canTransform argument target_frame'
    line = f"Waiting for transform map ->  base: {why} - frame does not exist"
    assert capsys.readouterr().err == f"[INFO] [7.000000000] [tf2_echo]: {line}\n" * 2
    assert echo.printed == 0


def test_it_prints_once_a_period(capsys):
    buffer = TransformBuffer()
    echo = echo_of(buffer)
    for number in range(22):
        fill(buffer, number * S // 10 + 1)
        echo.step(0, number / 10)

    stamps = [line for line in capsys.readouterr().out.splitlines() if line.startswith("At")]
    assert [stamp[:11] for stamp in stamps] == [
        f"At time {x}" for x in ("0.0", "0.5", "1.0", "1.5", "2.0")
    ]
    assert echo.printed == 5


def test_a_transform_that_is_lost_is_a_failure(capsys):
    buffer = TransformBuffer()
    fill(buffer, S)
    fill(buffer, 2 * S)
    echo = echo_of(buffer, time_ns=3 * S // 2)
    echo.step(0, 0.0)
    fill(buffer, 20 * S)
    fill(buffer, 21 * S)
    capsys.readouterr()

    echo.step(21 * S, 0.5)

    text = (
        "Lookup would require extrapolation into the past.  Requested time 1.500000 but the "
        "earliest data is at time 20.000000, when looking up transform from frame [base] to frame "
        "[map]"
    )
    assert capsys.readouterr().out == (
        f"Failure at 21.000\nException thrown:{text}\nThe current list of frames is:\n"
        "Frame base exists with parent map.\n\n"
    )


def test_json(capsys):
    buffer = TransformBuffer()
    fill(buffer, S)

    echo_of(buffer, is_json=True).step(0, 0.0)

    answer = json.loads(capsys.readouterr().out)
    assert (answer["time_ns"], answer["frame"], answer["child"]) == (S, "map", "base")
    assert answer["translation"] == [1.0, 2.0, -3.0]
    assert math.isclose(answer["rpy"][2], math.pi / 2)
