"""When new participants are introduced, on a simulated clock."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest

from launcher.ros.discovery import introductions, rtps
from launcher.ros.discovery.endpoints import contact_in
from launcher.ros.discovery.introductions import INTRODUCED_S, MOST_LOAD, POLL_S, _Domain
from tests.run.unit.request_bench import Clock

FIRST = 7410
RUNNING = {FIRST: "0"}


class Bench:
    """A domain in which ports appear; `announced` are the times and ports of introductions."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.clock = Clock()
        self.appear_s: dict[int, float] = {}
        self.announced: list[tuple[float, set[int]]] = []
        self.look_s = self.looked_s = 0.0  # of CPU, for one look and so far
        reactor = SimpleNamespace(call_later=self._call_later, now=lambda: self.clock.now)
        run: Any = SimpleNamespace(reactor=reactor)
        monkeypatch.setattr(introductions, "occupied_sockets", self._sockets)
        monkeypatch.setattr(time, "thread_time", lambda: self.looked_s)
        self.domain = _Domain(run, 0)
        monkeypatch.setattr(self.domain, "_send", self._sent)

    def _call_later(self, delay_s: float, do: Any) -> object:
        timer = SimpleNamespace(when=self.clock.now + delay_s, do=do)
        timer.cancel = lambda: setattr(timer, "do", lambda: None)
        self.clock.call_later(delay_s, lambda: timer.do())
        return timer

    def _sockets(self, number: int) -> dict[int, str]:
        now = self.clock.now
        self.looked_s += self.look_s
        new = {port: str(when) for port, when in self.appear_s.items() if when <= now}
        return RUNNING | new

    def _sent(self, message: bytes, ports: Any) -> None:
        (sample,) = rtps.parts(message, bytes(rtps.PREFIX_BYTES))
        assert isinstance(sample, rtps.Data)
        if not sample.gone:
            listed = rtps.parameters(sample.payload)[1]
            found = [contact_in(sample.payload)[0]] if not listed else []
            found += [int.from_bytes(value[4:8], "little") for key, value in listed if key == 0x32]
            self.announced.append((self.clock.now, set(found)))

    def start(self, count: int, apart_s: float) -> None:
        for number in range(count):
            self.appear_s[FIRST + 2 * number + 2] = 0.1 + number * apart_s
            self.domain.expect(-1)
        self.clock.run(60.0)


def test_one_is_introduced_at_once_and_again_for_a_busy_machine(monkeypatch: pytest.MonkeyPatch):
    bench = Bench(monkeypatch)
    bench.start(1, 0.0)
    ages = [when - bench.appear_s[FIRST + 2] for when, _ in bench.announced]
    assert len(ages) == len(INTRODUCED_S)
    for age, wished in zip(ages, INTRODUCED_S, strict=True):
        assert wished <= age <= wished + 2.5 * POLL_S


def test_many_that_start_together_are_introduced_together(monkeypatch: pytest.MonkeyPatch):
    bench = Bench(monkeypatch)
    bench.start(20, 0.04)
    assert len(bench.announced) < 20 * len(INTRODUCED_S) / 2
    for port, appeared_s in bench.appear_s.items():
        times = [when for when, ports in bench.announced if port in ports]
        assert len(times) >= 2
        assert max(times) >= appeared_s + max(INTRODUCED_S)


def test_one_that_is_restarted_within_a_poll_has_the_same_port(monkeypatch: pytest.MonkeyPatch):
    bench = Bench(monkeypatch)
    port = FIRST + 2
    bench.appear_s[port] = 0.1
    bench.domain.expect(-1)
    bench.clock.run(2.0)
    before = len(bench.announced)
    bench.appear_s[port] = bench.clock.now
    bench.domain.expect(-1)
    bench.clock.run(3.0)
    assert [ports for _, ports in bench.announced[before:]] == [{port}] * len(INTRODUCED_S)


def test_looks_that_take_long_are_rare(monkeypatch: pytest.MonkeyPatch):
    """Beside a hundred nodes, while others start that never have a participant."""
    bench = Bench(monkeypatch)
    bench.look_s = 0.004
    seconds = 20
    for second in range(seconds):
        bench.domain.expect(-1)
        bench.clock.run(second + 1.0)
    assert bench.looked_s <= 1.1 * MOST_LOAD * seconds
