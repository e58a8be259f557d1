"""A signal handler that raises KeyboardInterrupt while rclpy fills a message."""

from __future__ import annotations

import contextlib
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from launcher.ros.messages.decoding import decoder
from launcher.ros.service_caller import ServiceCaller
from launcher.ros.topics.clock import SimClock

DATA = serialize_message(String(data="words"))


def interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_a_message_is_made_of_bytes():
    assert decoder(String)(DATA) == String(data="words")


def test_an_interrupt_meanwhile_stays_one(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(String, "__init__", interrupt)
    with pytest.raises(KeyboardInterrupt):
        decoder(String)(DATA)


class _Taken(contextlib.nullcontext[None]):
    """The handle of a subscription that takes messages as bytes."""

    def __init__(self, *messages: bytes) -> None:
        super().__init__()
        self._messages = [*messages]

    def take_message(self, kind: object, raw: bool) -> Any:
        assert raw
        return (self._messages.pop(0), {}) if self._messages else None


def test_the_clock_of_a_simulation(monkeypatch: pytest.MonkeyPatch):
    tick = Clock()
    tick.clock.sec = 7
    data = serialize_message(tick)
    subscription = SimpleNamespace(handle=_Taken(data, data), msg_type=Clock)
    node = SimpleNamespace(create_subscription=lambda *_, **__: subscription)
    clock = SimClock()
    clock.start(SimpleNamespace(node=node))  # type: ignore[arg-type]
    assert clock.now_ns() == 7_000_000_000

    subscription.handle = _Taken(data)
    monkeypatch.setattr(Clock, "__init__", interrupt)
    with pytest.raises(KeyboardInterrupt):
        clock.now_ns()


def test_an_interrupt_while_an_answer_is_taken():
    def spin_once(timeout_sec: float) -> None:
        # as Python says it of a function of C that returns a value although it has failed
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    caller = ServiceCaller.__new__(ServiceCaller)
    caller._executor = SimpleNamespace(spin_once=spin_once)

    with pytest.raises(KeyboardInterrupt):
        caller.spin_until(lambda: False, 1.0)
