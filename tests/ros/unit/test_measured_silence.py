"""What `topic hz`, `bw` and `delay` say at the end of `--for` about few messages or none."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import pytest
from std_msgs.msg import Header

from launcher.ros.snapshot.ros_graph import EndpointInfo, GraphSnapshot
from launcher.ros.topics.listener import ReceivedMessage, TopicTarget
from launcher.ros.topics.qos import QosOptions
from launcher.ros.topics.statistics import NANOS
from launcher.ros.verb import GraphAccess
from launcher.ros.verbs import measurements
from tests.support.verbs import in_process

VERBS = {
    "hz": measurements.Rates,
    "bw": measurements.Bandwidths,
    "delay": measurements.Ages,
}
Measured = Callable[..., tuple[int, str, str]]


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Measured:
    """Runs a verb as if messages had arrived at these seconds; exit code, output and errors."""

    def run(
        name: str, times_s: Sequence[float], observing: Any = None, **more: Any
    ) -> tuple[int, str, str]:
        def listen(self: measurements.Measurement, observer: object) -> None:
            for topic in self.topics:
                self.found(TopicTarget(name=topic, type="x", publishers=()))
            message: Any = b"12" if self.is_raw else SimpleNamespace(header=Header())
            for time_s in times_s:
                received_ns = round(time_s * NANOS)
                info = {"received_timestamp": received_ns}
                self.take(ReceivedMessage(topic="/t", message=message, info=info), received_ns)
            self.report()

        monkeypatch.setattr(measurements.Measurement, "_listen", listen)
        monkeypatch.setattr(measurements, "observing", observing or no_graph)
        given = {"for_s": 2.0, "json": False, "window": 100, "use_sim_time": False}
        options = measurements.MeasureOptions(
            access=GraphAccess(0, 1.0),
            qos=QosOptions(),
            **{"topics": ["t"], **given, **more},
        )
        code = VERBS[name](options).run()
        return (int(code), *capsys.readouterr())

    return run


@contextlib.contextmanager
def no_graph(*words: object, **more: object) -> Iterator[object]:
    graph = GraphSnapshot(domain_id=0, nodes=("/n",), infos=tuple(map(published, "tuv")))
    yield SimpleNamespace(prefetched_graph=lambda: graph)


def published(letter: str) -> EndpointInfo:
    return EndpointInfo(
        topic=f"rt/{letter}",
        node="/n",
        direction="publisher",
        type="x",
        reliability="RELIABLE",
        durability="VOLATILE",
    )


NOTHING = "no message on /t within 2 s\n"


@pytest.mark.parametrize(
    ("name", "times_s", "error"),
    [
        ("hz", [], NOTHING),
        ("hz", [0.5], "only one message on /t within 2 s\n"),
        ("bw", [], NOTHING),
        ("bw", [0.5], "only one message on /t within 2 s\n"),
        ("delay", [], NOTHING),
    ],
)
def test_too_few_messages_are_an_error(measured: Measured, name: str, times_s, error: str):
    code, out, err = measured(name, times_s)
    assert (code, out.removeprefix("Subscribed to [/t]\n"), err) == (1, "", error)


@pytest.mark.parametrize(
    ("name", "times_s", "text"),
    [
        ("hz", [0.5, 1.0, 1.5], "average rate: 2.000\n"),
        ("bw", [0.5, 1.0], "B/s from 2 messages\n"),
        ("delay", [0.5], "average delay: 0.500\n"),
    ],
)
def test_what_was_never_due_is_printed_at_the_end(measured: Measured, name: str, times_s, text):
    code, out, err = measured(name, times_s)
    assert (code, text in out, err) == (0, True, "")


def test_silence_without_an_end_is_no_error(measured: Measured):
    assert all(measured(name, [], for_s=None)[0] == 0 for name in ("hz", "bw", "delay"))


def test_silence_is_told_in_json_and_with_a_minimum_too(measured: Measured):
    code, out, err = measured("hz", [], json=True, min_hz=1.0)
    assert (code, err) == (1, NOTHING)
    total = {"version": 1, "topic": "/t", "event": "total", "messages": 0, "mean_hz": 0.0}
    assert json.loads(out) == total
    code, out, err = measured("hz", [], min_hz=1.0, filter="True")
    assert (code, out, err) == (1, "", NOTHING.replace("message", "message that fits --filter"))


CLEAR = "\x1b[H\x1b[2J\n"


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("hz", "/t      2.000   0.500       0.500       0.00000   2     \n\n"),
        ("bw", " 3        2 B    2 B   2 B\n\n"),
    ],
)
def test_all_topics_are_measured_below_a_cleared_screen(
    measured: Measured, monkeypatch: pytest.MonkeyPatch, name: str, line: str
):
    _, out, _ = measured(name, [0.5, 1.0, 1.5], topics=[])
    assert "\x1b" not in out  # no terminal
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)

    code, out, err = measured(name, [0.5, 1.0, 1.5], topics=[])
    assert (code, err) == (0, "")
    first, *subscribed = out.partition(CLEAR)[0].splitlines()
    assert first == "Subscribing to all 3 available topics..."
    assert subscribed == [f"Subscribed to [/{letter}]" for letter in "tuv"]
    assert out.partition(CLEAR)[2].endswith(line)


def test_no_topics_at_all_are_an_error_with_the_reason(measured: Measured):
    for name in ("hz", "bw"):
        for for_s in (None, 2.0):
            code, out, err = measured(name, [], empty_graph, topics=[], for_s=for_s)
            assert (code, out) == (1, "No topics available\n")
            assert err.startswith("hint: 0 nodes on domain 0")


@contextlib.contextmanager
def empty_graph(*words: object, **more: object) -> Iterator[object]:
    graph = GraphSnapshot(domain_id=0, nodes=(), infos=())
    yield SimpleNamespace(prefetched_graph=lambda: graph)


def test_the_lines_of_bandwidth_say_what_they_are(measured: Measured, monkeypatch):
    monkeypatch.setattr("launcher.ros.topics.clock.WallClock.now_ns", lambda self: 2 * NANOS)
    code, out, _ = measured("bw", [0.0, 0.5, 1.0], json=True, window=2)

    *rates, total = map(json.loads, out.splitlines())
    assert (code, {one["event"] for one in rates}) == (0, {"rate"})
    assert total == {
        "version": 1,
        "topic": "/t",
        "event": "total",
        "messages": 3,
        "bytes": 6,
        "bytes_per_s": 3.0,
    }
    assert json.loads(measured("delay", [0.5], json=True)[1])["event"] == "delay"


def test_one_of_several_topics_that_is_silent_is_an_error_but_not_one_of_all(measured: Measured):
    two = measured("hz", [0.5, 1.0], topics=["/t", "/u"])
    assert (two[0], two[2]) == (1, NOTHING.replace("/t", "/u"))
    assert two[1].startswith("Subscribed to [/t]\nSubscribed to [/u]\n")
    assert measured("hz", [0.5, 1.0], topics=[])[::2] == (0, "")
    nothing = "nothing to measure on 3 topics within 2 s\n"
    assert measured("hz", [0.5], topics=[])[::2] == (1, nothing)
    assert measured("bw", [], topics=[])[::2] == (1, nothing)


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["/a", "--all"], "Cannot specify both --all/-a and topic names"),
        ([], "NAME is missing"),
    ],
)
@pytest.mark.parametrize("name", ["hz", "bw"])
def test_names_and_all_exclude_each_other(name: str, words: list[str], error: str):
    answer = in_process("topic", name, *words)
    assert (answer.code, answer.err.splitlines()[0]) == (2, f"error: {error}")
