"""What is known of a host that cannot be reached, as text for users."""

from __future__ import annotations

import errno

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import ProcessSpec, StopPolicy
from launcher.hosts.engine.link import LinkState
from launcher.hosts.engine.remote_host import RemoteChild, RemoteHost
from launcher.hosts.file.hosts_model import Host
from launcher.run.logs import messages
from launcher.run.processes.machine_events import MachineCommand, ReportExit
from launcher.run.processes.process import Process


class Link:
    """Silent for 4 s; keeps what it gets."""

    silent_s = 4.0

    def __init__(self, stop_after_s: float | None = None) -> None:
        self.stop_after_s = stop_after_s
        self.written: list[tuple[int, bytes]] = []

    def write_stdin(self, process_id: int, data: bytes) -> None:
        self.written.append((process_id, data))


def remote(link: Link, **more: str) -> RemoteHost:
    host = RemoteHost(Host(name="bot1", address="10.0.0.2", **more))
    host.link = link  # type: ignore[assignment]
    host.state = LinkState.READY
    return host


def test_it_tells_since_when_it_is_unreachable_and_what_its_processes_do():
    host = remote(Link())
    assert host.unreachable_s is None
    host.state = LinkState.UNREACHABLE
    assert host.unreachable_s == 4.0
    assert host.policy() == "its processes run on"
    assert remote(Link(10.0)).policy() == "its processes are stopped there after 10 s"
    host.state = LinkState.GONE
    assert host.unreachable_s is None


def test_it_tells_what_was_caught_up_since_the_link_was_lost():
    host = remote(Link())
    host.events, host.lines = 7, 700
    host.lost(100.0)
    assert host.lost_at_s == 96.0
    host.events, host.lines = 1, 120
    assert host.caught_up() == "caught up with 1 event and 120 lines"
    host.dropped = 40
    assert host.caught_up().endswith("; about 40 lines of output lost")


def test_it_is_named_with_its_user_and_address():
    assert remote(Link()).place == "bot1 (10.0.0.2)"
    assert remote(Link(), user="robot").place == "bot1 (robot@10.0.0.2)"


def test_the_end_waits_for_it_as_long_as_the_slowest_stop_takes():
    host = remote(Link())
    idle_s = host.longest_stop_s
    for number, wait_s in enumerate((1.0, 7.0, 600.0)):
        spec = ProcessSpec(name="a", label="a", argv=("a",), env={})
        one = Process(number, spec, number=number, prefix=b"")
        one.machine.stop = StopPolicy(sigterm_timeout_s=wait_s, sigkill_timeout_s=1.0)
        if wait_s < 600.0:
            one.machine.handle(MachineCommand.START, 0.0)
        host.processes.append(one)
    assert host.longest_stop_s == idle_s + 8.0


def test_standard_input_is_sent_whole_or_refused():
    link = Link()
    host = remote(link)
    child = RemoteChild(4242, 3, host)
    assert child.write_stdin(b"hello\n") == 6
    assert link.written == [(3, b"hello\n")]
    host.state = LinkState.UNREACHABLE
    with pytest.raises(OSError, match="No route to host") as refused:
        child.write_stdin(b"more\n")
    assert refused.value.errno == errno.EHOSTUNREACH
    child.signal_group(9)
    child.close()


@pytest.mark.parametrize(("code", "has_hint"), [(2, True), (1, False)])
def test_a_host_without_the_executable_is_to_be_synchronized(code: int, has_hint: bool):
    spec = ProcessSpec(name="a-1", label="a", argv=("/ws/lib/p/a",), env={})
    process = Process(1, spec, number=0, prefix=b"")
    process.host = remote(Link())
    process.words_there = ("python3", "-m", "launcher", "run", "p", "a")
    end = ReportExit(Outcome(returncode=code), asked=False, retry_in_s=None)
    text = messages.ended(process, 7, end).text
    assert "cmd 'python3 -m launcher run p a'" in text
    assert text.endswith("if bot1 lacks it: python -m launcher hosts sync") is has_hint
