"""The tree of frames, and what is wrong with it."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from launcher.ros.tf.arithmetic import Transform
from launcher.ros.tf.frame_buffer import StampedTransform
from launcher.ros.tf.frame_tree import FrameTree, TfSample

S = 1_000_000_000
NOW = 105 * S


def sample(*edges: str, at_s: float = 104.9, static: bool = False, by: str = "/robot") -> TfSample:
    """A message with transforms such as `map>odom`."""
    pairs = (edge.split(">") for edge in edges)
    stamp_ns = round(at_s * S)
    found = [StampedTransform(parent, child, stamp_ns, Transform()) for parent, child in pairs]
    return TfSample(stamp_ns, static, by, found)


def tree_of(*samples: TfSample) -> FrameTree:
    tree = FrameTree()
    for one in samples:
        tree.take(one)
    return tree


def moving(*edges: str, by: str = "/robot") -> list[TfSample]:
    """At 10 Hz for five seconds, up to now."""
    return [sample(*edges, at_s=100 + number / 10, by=by) for number in range(51)]


ROBOT = [
    *moving("map>odom", "odom>base"),
    sample("base>laser", "base>camera", at_s=3.0, static=True, by="/description"),
]


def test_the_tree_as_text():
    assert list(tree_of(*ROBOT).lines(NOW)) == [
        "map",
        "└─ odom          10.0 Hz, buffer 5.00 s, newest 0.00 s, oldest 5.00 s old (by /robot)",
        "   └─ base       10.0 Hz, buffer 5.00 s, newest 0.00 s, oldest 5.00 s old (by /robot)",
        "      ├─ camera  static (by /description)",
        "      └─ laser   static (by /description)",
    ]


def test_problems_come_first():
    lines = list(tree_of(*ROBOT, sample("odom>base", at_s=105, by="/other")).lines(NOW))

    assert lines[:3] == ["problem: base is broadcast by several nodes: /robot, /other", "", "map"]


@pytest.mark.parametrize(
    ("samples", "kind", "text"),
    [
        (
            [*ROBOT, sample("map>base", by="/other")],
            "several parents",
            "base has several parents: odom (by /robot) and map (by /other)",
        ),
        (
            [sample("a>b", "b>c", "c>a")],
            "loop",
            "the frames are a loop: a -> c -> b -> a (child -> parent)",
        ),
        (
            [*ROBOT, sample("space>moon", static=True)],
            "several trees",
            "there are 2 unconnected trees: map, space",
        ),
        (
            [*ROBOT, sample("base>arm", at_s=99)],
            "old",
            "arm is old: its last transform is 6.0 s old",
        ),
        (
            [*ROBOT, sample("base>arm", at_s=107.5)],
            "future",
            "arm is 2.5 s in the future: clocks differ",
        ),
        (
            [*ROBOT, *[sample("base>base")] * 2],
            "ignored",
            "base: 2 ignored, TF_SELF_TRANSFORM: parent and child are the same frame (by /robot)",
        ),
    ],
)
def test_problems(samples, kind, text):
    [problem] = tree_of(*samples).problems(NOW)

    assert (problem.kind, problem.text) == (kind, text)


def test_a_slow_frame_is_not_old():
    slow = [sample("map>odom", at_s=at_s) for at_s in (96, 98, 100, 102)]

    assert tree_of(*slow).problems(NOW) == []
    assert [one.kind for one in tree_of(*slow).problems(NOW + 8 * S)] == ["old"]


def test_a_loop_is_shown_once_with_what_is_below_it():
    lines = list(tree_of(sample("a>b", "b>a", "b>c", "x>y")).lines(NOW))

    shown = [line.partition("  one")[0].rstrip() for line in lines[lines.index("") + 1 :]]
    assert shown == ["x", "└─ y", "a", "└─ b", "   └─ c"]


def test_a_frame_between_two_parents_is_below_both_each_with_its_rate():
    tree = tree_of(*moving("a>cam", by="/one"), *moving("b>cam", "cam>lens", by="/two"))
    lines = list(tree.lines(NOW))

    assert lines[:3] == [
        "problem: cam has several parents: a (by /one) and b (by /two)",
        "problem: there are 2 unconnected trees: a, b",
        "",
    ]
    shown = [line.replace("buffer 5.00 s, newest 0.00 s, oldest 5.00 s old ", "") for line in lines]
    assert shown[3:] == [
        "a",
        "└─ cam      10.0 Hz, (by /one)",
        "b",
        "└─ cam      10.0 Hz, (by /two)",
        "   └─ lens  10.0 Hz, (by /two)",
    ]
    document = tree.document(NOW)
    assert document["roots"] == ["a", "b"]
    assert [one["transforms"] for one in document["frames"]] == [51, 51]
    assert tree.dot(NOW).count("Average rate: 10.0") == 3


def test_two_parents_in_one_tree():
    tree = tree_of(*ROBOT, sample("map>base"))

    frames = [row.strip("└├│─ ") for row, _ in tree.rows(NOW)]
    assert frames == ["map", "base", "camera", "laser", "odom", "base"]
    assert tree.roots() == ["map"]


@pytest.mark.parametrize("at_s", [5.0, 1_796_004_107.0])
def test_stamps_of_another_clock_have_no_age(at_s):
    tree = tree_of(sample("map>odom", at_s=at_s))
    now_ns = 1_796_004_112 * S if at_s < 10 else NOW
    [problem] = tree.problems(now_ns)

    assert problem.text == f"odom: its stamp {at_s} is far from now (simulated time?)"
    assert problem.kind == ("old" if at_s < 10 else "future")
    assert tree.rows(now_ns)[1][1] == (
        f"one transform, buffer 0.00 s, stamps {at_s:.2f} to {at_s:.2f} (by /robot)"
    )


def test_as_a_document():
    document = tree_of(*ROBOT).document(NOW)

    assert document["roots"] == ["map"]
    assert document["problems"] == []
    assert document["frames"][0] == {
        "frame": "base",
        "parent": "odom",
        "static": False,
        "broadcasters": ["/robot"],
        "transforms": 51,
        "rate_hz": pytest.approx(10.0),
        "buffer_s": pytest.approx(5.0),
        "newest_ns": NOW,
        "oldest_ns": 100 * S,
    }


def test_as_view_frames_draws_it():
    tree = tree_of(*moving("map>odom"), sample('odom>las"er', at_s=3.0, static=True, by=""))

    assert tree.dot(NOW).splitlines() == [
        "digraph G {",
        '"map" -> "odom"[label=" Broadcaster: /robot\\nAverage rate: 10.0\\nBuffer length: 5.0\\n'
        'Most recent transform: 105.0\\nOldest transform: 100.0\\n"];',
        '"odom" -> "las\\"er"[label=" Broadcaster: default_authority\\nAverage rate: 10000.0\\n'
        'Buffer length: 0.0\\nMost recent transform: 0.0\\nOldest transform: 0.0\\n"];',
        "edge [style=invis];",
        ' subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";',
        '"Recorded at time: 105.0"[ shape=plaintext ] ;',
        '}->"map";',
        "}",
    ]
    assert FrameTree().dot(NOW) == 'digraph G { "No tf data received" }\n'


def test_what_listeners_ignore_is_no_frame():
    broken = StampedTransform("map", "odom", 0, Transform((math.nan, 0.0, 0.0)))
    tree = tree_of(TfSample(0, False, "", [broken]))

    assert tree.courses == {}
    assert [one.text for one in tree.problems(NOW)] == [
        "odom: 1 ignored, TF_NAN_INPUT: it contains nan"
    ]


def test_what_has_ended_is_forgotten():
    tree = tree_of(
        sample("map>base", at_s=90, by="/other"),
        sample("base>base", at_s=90),
        sample("space>moon", at_s=90),
        *ROBOT,
    )
    kinds = [problem.kind for problem in tree.problems(NOW)]
    assert kinds == ["several parents", "old", "several trees", "ignored"]

    tree.forget(95 * S)
    tree.take(sample("odom>base", at_s=105.5))

    assert [problem.kind for problem in tree.problems(NOW)] == ["future", "old", "several trees"]
    assert tree.courses["base"].last.rate_hz == pytest.approx(2.0)
    assert list(tree.courses["laser"].broadcasters) == ["/description"]


def test_a_deep_tree():
    frames = [f"f{number:04}" for number in range(3000)]
    tree = tree_of(sample(*(f"{one}>{other}" for one, other in pairwise(frames))))

    assert len(tree.rows(NOW)) == 3000
    assert tree.problems(NOW) == []


def test_a_quaternion_that_kilted_ignores_is_a_problem():
    [problem] = tree_of(
        TfSample(
            NOW, True, "/r", [StampedTransform("a", "b", NOW, Transform(rotation=(0, 0, 0, 2.0)))]
        )
    ).problems(NOW)

    assert problem.text == (
        "b: 1 ignored, TF_DENORMALIZED_QUATERNION from Kilted on: the length of its quaternion is "
        "not 1 (by /r)"
    )


def test_a_recording_of_a_simulation_has_the_time_of_its_stamps():
    tree = tree_of(sample("map>odom", at_s=5), sample("odom>base", at_s=7))
    assert tree.clock_ns(1_796_004_112 * S) == 7 * S

    tree.take(sample("base>arm", at_s=1_796_004_112))
    assert tree.clock_ns(1_796_004_112 * S) == 1_796_004_112 * S
    assert tree_of(*ROBOT).clock_ns(NOW) == NOW
