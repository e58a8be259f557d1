"""A LinkListener for tests: notes what a link reports, and drives the loop until it fits."""

from __future__ import annotations

import os
import select
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from launcher.hosts.engine.agent_link import AgentLink, SshTransport
from launcher.hosts.engine.link import LinkContext, LinkState
from launcher.hosts.engine.replica import Replica
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.file.order import Order
from launcher.posix.reactor import Reactor
from launcher.run.processes.machine_events import Exited, MachineCommand, MachineEvent
from tests.support.children import children_named
from tests.support.command_transport import CommandTransport
from tests.support.repository import REPOSITORY

DEADLINE_S = 60.0
AGENT = (sys.executable, "-m", "launcher", "agent")
RELAYED = ("sh", "-c", 'cat | "$@" | cat', "sh", *AGENT)


def python(code: str, **fields: Any) -> Order:
    """An order that runs a Python program."""
    words = ((sys.executable,), ("-u",), ("-c",), (code,))
    return Order(**{"name": "p", "label": "p", "words": words, "environment": {}, **fields})


class Recorder:
    """Use `with`; `link` is open."""

    def __init__(
        self,
        host: Host | None = None,
        *,
        words: Sequence[str] = AGENT,
        run_id: str = "",
        environment: Mapping[str, str] | None = None,
        by_ssh: bool = False,
    ) -> None:
        self.reactor = Reactor()
        self.host = host or Host(name="bot1", address="here")
        env = {**os.environ, "PYTHONPATH": str(REPOSITORY), **(environment or {})}
        self.events: list[tuple[int, MachineEvent, float, int]] = []
        self.replicas: dict[int, Replica] = {}
        self.blocks: list[tuple[int, str, bytes, float]] = []
        self.states: list[tuple[LinkState, str]] = []
        self.warnings: list[str] = []
        self.resources: dict[int, Mapping[str, Any]] = {}
        self.lines_dropped = 0
        self.end: tuple[list[str], bool] | None = None
        context = LinkContext(
            host=self.host,
            listener=self,
            reactor=self.reactor,
            run_id=run_id or f"{os.getpid()}-{os.urandom(4).hex()}",
            environment=env,
        )
        make = SshTransport(self.host, env) if by_ssh else CommandTransport(self.host, words, env)
        self.link = AgentLink(context, make)

    def __enter__(self) -> Recorder:
        self.link.open()
        return self

    def __exit__(self, *exc: object) -> None:
        self.link.close()
        self.reactor.close()

    # ---- driving

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Turn the loop until it is true; fails the test after a minute."""
        deadline = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < deadline, f"{what}: {self.states} {self.warnings}"
            self._wait()

    def _wait(self) -> None:
        timeout_s = self.reactor.timeout_s()
        wait_s = 0.05 if timeout_s is None else min(0.05, timeout_s)
        with suppress(InterruptedError):
            select.select([self.reactor.fileno()], [], [], wait_s)
        self.reactor.turn()

    def ready(self) -> Recorder:
        self.until(lambda: self.link.state is LinkState.READY, "the host is ready")
        return self

    def start(self, process_id: int, order: Order) -> None:
        self.replicas[process_id] = Replica(order.restart, order.stop)
        self.link.prepare(process_id, order)
        self.link.command(process_id, MachineCommand.START)

    def finish(self, *, at_once: bool = False) -> tuple[list[str], bool]:
        self.link.finish(at_once=at_once)
        self.until(lambda: self.end is not None, "the host has finished")
        assert self.end is not None
        return self.end

    def sever(self) -> None:
        """Kill what is between us and the agent; for a recorder with the words RELAYED."""
        process = self.link._process
        assert process is not None
        for pid in (process.pid, *children_named(process.pid, "cat")):
            os.kill(pid, signal.SIGKILL)

    # ---- what was recorded

    def text(self, process_id: int = 1) -> bytes:
        return b"".join(data for number, _, data, _ in self.blocks if number == process_id)

    def pid(self, process_id: int = 1) -> int:
        """Of the last start, on the host."""
        found = [pid for number, _, _, pid in self.events if number == process_id and pid > 0]
        return found[-1] if found else 0

    def exits(self, process_id: int = 1) -> list[int | None]:
        return [
            event.outcome.returncode
            for number, event, _, _ in self.events
            if number == process_id and isinstance(event, Exited)
        ]

    # ---- LinkListener

    def event(
        self, process_id: int, event: MachineEvent, at_s: float, pid: int, left_s: float | None
    ) -> None:
        self.events.append((process_id, event, at_s, pid))
        if process_id in self.replicas:
            self.replicas[process_id].follow(event, at_s, left_s)

    def output(self, process_id: int, stream: str, data: bytes, at_s: float) -> None:
        self.blocks.append((process_id, stream, data, at_s))

    def dropped(self, host: str, lines: int) -> None:
        self.lines_dropped += lines

    def samples(self, host: str, samples: Mapping[int, Mapping[str, Any]]) -> None:
        self.resources.update(samples)

    def link_changed(self, host: str, state: LinkState, reason: str) -> None:
        self.states.append((state, reason))

    def warn(self, host: str, text: str) -> None:
        self.warnings.append(text)

    def finished(self, host: str, leftovers: Sequence[str], *, killed: bool) -> None:
        self.end = (list(leftovers), killed)
