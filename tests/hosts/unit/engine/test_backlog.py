"""The last lines of a run that is attached to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from launcher.hosts.engine import hosts_backlog
from launcher.hosts.engine.driver import HostsDriver
from launcher.hosts.engine.hosts_backlog import HostsBacklog, last_lines
from launcher.hosts.engine.link import LinkState
from launcher.hosts.engine.remote_host import RemoteHost
from launcher.hosts.file.hosts_model import Host
from launcher.posix.reactor import Reactor


def test_the_last_lines_are_those_of_all_hosts():
    held = [
        (1, "both", b"a1\n", 1.0),
        (1, "both", b"a3\n", 3.0),
        (2, "both", b"b2\n", 2.0),
        (2, "both", b"b4 ", 4.0),  # a long line in pieces
        (2, "both", b"b4\n", 4.1),
        (3, "both", b"unfinished", 5.0),
    ]

    assert [one[2] for one in last_lines(held, 3)] == [b"a3\n", b"b4 ", b"b4\n", b"unfinished"]
    assert [one[2] for one in last_lines(held, 9)][:3] == [b"a1\n", b"b2\n", b"a3\n"]
    assert last_lines(held, 0) == []


class Begun(HostsBacklog):
    """Of two hosts, the last two lines; `shown` is what it has shown."""

    def __init__(self, reactor: Reactor, lines: int = 2) -> None:
        self.shown: list[bytes] = []
        super().__init__(lines, ("bot1", "bot2"), reactor, self._keep)

    def _keep(self, number: int, stream: str, data: bytes, at_s: float) -> None:
        self.shown.append(data)

    def line(self, host: str, data: bytes, at_s: float) -> None:
        self.add(host, (1, "both", data, at_s))


def test_output_is_held_until_all_hosts_have_told_their_last_lines():
    with Reactor() as reactor:
        one = Begun(reactor)
        one.line("bot2", b"b2\n", 2.0)
        one.line("bot1", b"a1\n", 1.0)
        one.line("bot1", b"a3\n", 3.0)
        one.complete("bot1")
        assert one.shown == []
        one.complete("bot2")
        one.complete("bot2")
        one.close()

    assert one.shown == [b"b2\n", b"a3\n"]


@pytest.mark.parametrize("lines", [0, 2])
def test_new_output_is_not_cut(lines: int):
    new = [b"%d\n" % number for number in range(5)]
    with Reactor() as reactor:
        one = Begun(reactor, lines)
        one.line("bot1", b"past\n", 1.0)
        one.complete("bot1")
        for data in new:
            one.line("bot1", data, 2.0)
        one.complete("bot2")
        one.line("bot2", b"last\n", 3.0)

    assert one.shown == [b"past\n", *new, b"last\n"][not lines :]


@pytest.mark.parametrize("is_event", [False, True])
def test_the_past_of_a_late_host_is_cut_and_in_order(monkeypatch, is_event: bool):
    monkeypatch.setattr(hosts_backlog, "WAIT_S", 0.1)
    with Reactor() as reactor:
        one = Begun(reactor)
        one.line("bot1", b"a\n", 2.0)
        one.line("bot2", b"b1\n", 1.0)
        one.complete("bot1")
        if is_event:
            one.flush()
        while not one.shown:
            reactor.turn()
        one.line("bot1", b"new\n", 9.0)
        one.line("bot2", b"b4\n", 4.0)
        one.line("bot2", b"b3\n", 3.0)
        assert one.shown == [b"a\n", b"new\n"]
        one.complete("bot2")

    assert one.shown == [b"a\n", b"new\n", b"b3\n", b"b4\n"]


def test_all_that_is_held_is_shown_at_the_end():
    with Reactor() as reactor:
        one = Begun(reactor)
        one.line("bot1", b"a\n", 1.0)
        one.close()

    assert one.shown == [b"a\n"]


@pytest.mark.parametrize(
    ("state", "is_shown"), [(LinkState.UNREACHABLE, False), (LinkState.GONE, True)]
)
def test_the_past_of_a_host_is_awaited_as_long_as_it_may_return(state: LinkState, is_shown: bool):
    shown: list[bytes] = []
    reader: Any = SimpleNamespace(feed=lambda process, stream, data, at_s: shown.append(data))
    fleet: Any = SimpleNamespace(pause=None, named=str, link_changed=lambda *state: None)
    with Reactor() as reactor:
        run: Any = SimpleNamespace(reactor=reactor, reader=reader, log=None)
        driver = HostsDriver(run, fleet)
        host = RemoteHost(Host("bot1", "bot1.local"))
        host.state = LinkState.READY
        driver._remote[1] = cast(Any, SimpleNamespace(host=host))
        driver.begin_with(1, ["bot1", "bot2"])
        driver.output(1, "both", b"past\n", 1.0)
        driver.link_changed("bot1", state, "")
        driver.past_complete("bot2")

    assert bool(shown) == is_shown
