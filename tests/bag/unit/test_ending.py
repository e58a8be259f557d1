"""Ctrl-C while a bag is recorded or played: one or several signals."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from launcher.bag.ros import ending as module
from launcher.bag.ros.ending import GIVE_UP_S, ending

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class _Clock:
    now_s = 100.0

    def monotonic(self) -> float:
        return self.now_s


@pytest.fixture
def clock(monkeypatch) -> Iterator[_Clock]:
    """The time of `ending`; at the end the handlers are those of before."""
    before = {one: signal.getsignal(one) for one in SIGNALS}
    clock = _Clock()
    monkeypatch.setattr(module, "time", clock)
    yield clock
    for signum, handler in before.items():
        signal.signal(signum, handler)


def test_signals_that_follow_at_once_are_one(clock: _Clock):
    with ending(interrupts=False) as ended:
        assert not ended()
        for signum in (*SIGNALS, *SIGNALS):
            signal.raise_signal(signum)
            clock.now_s += 0.1
        assert ended()
    for signum in SIGNALS:  # the exit code stays as it is
        signal.raise_signal(signum)


def test_a_late_one_interrupts_the_finishing(clock: _Clock):
    with pytest.raises(KeyboardInterrupt), ending(interrupts=False):
        signal.raise_signal(signal.SIGINT)
        clock.now_s += GIVE_UP_S + 0.1
        signal.raise_signal(signal.SIGTERM)


def test_the_first_one_interrupts_a_player(clock: _Clock):
    reached = False
    with ending(interrupts=True) as ended:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
        reached = ended()
    assert reached


def test_without_a_signal_handlers_are_as_before(clock: _Clock):
    before = [signal.getsignal(one) for one in SIGNALS]
    with ending(interrupts=True):
        pass
    assert [signal.getsignal(one) for one in SIGNALS] == before
