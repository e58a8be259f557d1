"""What `topic hz`, `bw` and `delay` say at the end of `--for` about few messages or none."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import pytest
from std_msgs.msg import Header

from launcher.ros.topics.listener import ReceivedMessage, TopicTarget
from launcher.ros.topics.qos import QosOptions
from launcher.ros.topics.statistics import NANOS
from launcher.ros.verb import GraphAccess
from launcher.ros.verbs import streams

Measured = Callable[..., tuple[int, str, str]]


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Measured:
    """Runs a verb as if messages had arrived at these seconds; exit code, output and errors."""

    def run(name: str, times_s: Sequence[float], **more: Any) -> tuple[int, str, str]:
        def measure(
            options: Any,
            clock: Any,
            found: Any,
            take: Any,
            report: Any,
            *,
            raw: bool,
        ) -> None:
            found(TopicTarget(name="/t", type="x", publishers=()))
            message = b"12" if raw else SimpleNamespace(header=Header())
            for time_s in times_s:
                info = {"received_timestamp": round(time_s * NANOS)}
                take(
                    ReceivedMessage(topic="/t", message=message, info=info),
                    info["received_timestamp"],
                )
            report()

        monkeypatch.setattr(streams, "_measure", measure)
        given = {"for_s": 2.0, "json": False, "window": 100, "use_sim_time": False}
        access, profile = GraphAccess(0, 1.0), QosOptions()
        options = streams.MeasureOptions(
            access=access, topics=["t"], qos=profile, **{**given, **more}
        )
        code = getattr(streams, name)(options)
        return (int(code), *capsys.readouterr())

    return run


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
