"""The event loop: what waits for an idle moment."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from launcher.posix import reactor as module
from launcher.posix.reactor import Reactor


@pytest.fixture
def reactor() -> Iterator[Reactor]:
    with Reactor() as made:
        yield made


def test_what_can_wait_comes_after_timers_and_readers_one_in_each_pass(reactor: Reactor):
    read_end, write_end = os.pipe()
    done: list[str] = []

    def read() -> None:
        done.append("read")
        os.read(read_end, 1)

    reactor.when_idle(lambda: done.append("idle"))
    reactor.when_idle(lambda: (done.append("idle, too"), os.write(write_end, b"x")))
    reactor.when_idle(lambda: (done.append("at last"), reactor.stop()))
    reactor.add_reader(read_end, read)
    reactor.call_later(0, lambda: done.append("timer"))
    os.write(write_end, b"x")
    reactor.run()
    assert done == ["read", "timer", "idle", "idle, too", "read", "at last"]
    os.close(read_end)
    os.close(write_end)


def test_a_loop_that_is_never_idle_does_it_nevertheless(
    reactor: Reactor, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(module, "IDLE_WITHIN_S", 0.0)

    def busy() -> None:
        reactor.call_later(0, busy)

    busy()
    reactor.when_idle(reactor.stop)
    reactor.run()


def test_a_stopped_loop_begins_nothing_more(reactor: Reactor):
    done: list[str] = []
    reactor.when_idle(reactor.stop)
    reactor.when_idle(lambda: done.append("more"))
    reactor.run()
    assert done == []
