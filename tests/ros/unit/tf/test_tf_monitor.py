"""The reports of `tf monitor`."""

from __future__ import annotations

import json

import pytest

from launcher.ros.tf.arithmetic import Transform
from launcher.ros.tf.frame_buffer import StampedTransform
from launcher.ros.tf.frame_tree import TfSample
from launcher.ros.tf.tf_monitor import TfMonitor

S = 1_000_000_000


def feed(monitor: TfMonitor, seconds: float, *, step: bool = True) -> None:
    """Two nodes at 4 Hz, whose transforms are 0.25 s and 0.5 s old when they arrive."""
    for number in range(round(seconds * 4) + 1):
        now_ns = 100 * S + number * S // 4
        for child, parent, age_ns, node in (
            ("odom", "map", S // 4, "/ekf"),
            ("base", "odom", S // 2, ""),
        ):
            stamped = StampedTransform(parent, child, now_ns - age_ns, Transform())
            monitor.take(TfSample(now_ns, False, node, [stamped]), now_ns)
        if step:
            monitor.step(now_ns, number / 4)


def test_all_frames_every_ten_seconds(capsys):
    feed(TfMonitor((), json=False), 10)

    assert (
        capsys.readouterr().out
        == """\
Gathering data on all frames for 10 seconds...



RESULTS: for all Frames

Frames:
Frame: base, published by <no authority available>, Average Delay: 0.5, Max Delay: 0.5
Frame: odom, published by /ekf, Average Delay: 0.25, Max Delay: 0.25

All Broadcasters:
Node: /ekf 4 Hz, Average Delay: 0.25 Max Delay: 0.25
Node: <no authority available> 4 Hz, Average Delay: 0.5 Max Delay: 0.5
"""
    )


def test_the_way_between_two_frames(capsys):
    monitor = TfMonitor(("base", "map"), json=False)
    feed(monitor, 9)
    assert capsys.readouterr().out == "Gathering data on base -> map for 10 seconds...\n"

    monitor.report()

    lines = capsys.readouterr().out.splitlines()
    assert lines[3:6] == [
        "RESULTS: for base to map",
        "Chain is: base -> odom -> map",  # tf2_monitor leaves out the root
        "Net delay     avg = 0.5: max = 0.5",
    ]


def test_the_time_that_it_gathers_is_no_longer_than_its_own(capsys):
    for for_s, shown in ((3.0, "3"), (25.0, "10")):
        monitor = TfMonitor(("base", "map"), json=False, for_s=for_s)
        feed(monitor, 1)
        assert capsys.readouterr().out == f"Gathering data on base -> map for {shown} seconds...\n"
        assert monitor.why_not() is None


def test_frames_that_are_not_there_are_awaited(capsys):
    monitor = TfMonitor(("base", "nose"), json=False)
    feed(monitor, 2)

    out, err = capsys.readouterr()
    assert out == ""
    assert str(monitor.why_not()).endswith("source_frame - frame does not exist")
    assert err.count("[tf2_monitor_main]: Waiting for transform base ->  nose: ") == 2


@pytest.mark.parametrize("frames", [(), ("map", "base")])
def test_json(capsys, frames):
    monitor = TfMonitor(frames, json=True)
    feed(monitor, 2)

    monitor.report()

    answer = json.loads(capsys.readouterr().out)
    assert answer["chain"] == (["map", "odom", "base"] if frames else [])
    net = {"mean_delay_s": 0.5, "max_delay_s": 0.5}
    assert answer["net_delay"] == (net if frames else None)
    assert answer["frames"][0]["broadcaster"] is None
    assert [one["rate_hz"] for one in answer["broadcasters"]] == [4.0, 4.0]
