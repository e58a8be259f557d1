"""A link to a machine in this process, with switches."""

from __future__ import annotations

import functools
from collections import deque
from collections.abc import Callable
from typing import Any

from launcher.hosts.engine.link import LinkContext, LinkState
from launcher.hosts.file.order import Order
from launcher.posix.reactor import Timer
from launcher.run.processes.machine_events import MachineCommand
from tests.support.loopback.machine import Machine

REFUSES = "refuses"  # hosts whose names begin so
MISSING = "missing"
SILENT = "silent"
SAMPLE_S = 0.2


class LoopbackLink:
    """`cut()`, `restore()`, `power_off()`, `leave()`, `leave_deaf()`.

    All calls go through queues, later on the reactor.

    A host named `refuses...` refuses the connection, one named `missing...` cannot be reached,
    and one named `silent...` does not answer.
    """

    def __init__(self, context: LinkContext) -> None:
        self.context = context
        self.host = context.host
        self.reactor = context.reactor
        self.state = LinkState.CONNECTING
        self.machine = Machine(self.reactor, context.environment, self._report)
        self.machine.on_idle = self._machine_idle
        self._is_cut = False
        self._heard_s = self.reactor.now()
        self._to_run: deque[tuple[str, tuple[Any, ...]]] = deque()
        self._to_host: deque[Callable[[], None]] = deque()
        self._leash: Timer | None = None
        self._is_finishing = False
        self._is_closed = False
        self._leftovers: list[str] = []
        self._is_deaf = False

    # ---- switches

    def cut(self) -> None:
        self._is_cut = True
        self._heard_s = self.reactor.now()
        self._change(LinkState.UNREACHABLE, "cut by the test")
        if self.stop_after_s is not None:
            self._leash = self.reactor.call_later(self.stop_after_s, self.machine.stop_all)

    def restore(self) -> None:
        if not self._is_cut:
            return
        self._is_cut = False
        if self._leash is not None:
            self._leash.cancel()
        self._pump_host()
        self._change(LinkState.READY, "")
        self._pump_run()

    def power_off(self) -> None:
        """It loses its power, and comes back without processes."""
        self.machine.kill()
        self._to_run.clear()
        self._is_cut = False
        self._change(LinkState.GONE, "it was restarted")
        self._pump_run()

    def leave(self) -> None:
        """At the end a process will be found that another one has left."""
        self._leftovers = ["sleep [7]"]

    def leave_deaf(self) -> None:
        """The same, and only SIGKILL ends it."""
        self.leave()
        self._is_deaf = True

    # ---- from the host to the run

    def _report(self, method: str, arguments: tuple[Any, ...]) -> None:
        self._to_run.append((method, arguments))
        if not self._is_cut:
            self.reactor.call_later(0, self._pump_run)

    def _pump_run(self) -> None:
        while self._to_run and not self._is_cut and not self._is_closed:
            method, arguments = self._to_run.popleft()
            if method == "changed":
                self.state = arguments[0]
                arguments = (self.host.name, *arguments)
                self.context.listener.link_changed(*arguments)
            elif method == "finished":
                name, left = self.host.name, self._leftovers
                self.context.listener.finished(name, left, killed=self._is_deaf)
            else:
                getattr(self.context.listener, method)(*arguments)

    def _change(self, state: LinkState, reason: str) -> None:
        if state is LinkState.UNREACHABLE:
            self.state = state
            report = functools.partial(
                self.context.listener.link_changed, self.host.name, state, reason
            )
            self.reactor.call_later(0, report)
            return
        self._to_run.append(("changed", (state, reason)))

    # ---- as a Link

    @property
    def silent_s(self) -> float:
        return self.reactor.now() - self._heard_s if self._is_cut else 0.0

    @property
    def stop_after_s(self) -> float | None:
        policy = self.host.on_link_loss
        return None if policy is None else policy.stop_after_s

    def unit(self, process_id: int) -> str:
        return f"launcher-{self.context.run_id.rpartition('-')[2]}-{process_id}.service"

    def open(self) -> None:
        if self.host.name.startswith(SILENT):
            return
        outcome = (LinkState.READY, "")
        if self.host.name.startswith(REFUSES):
            outcome = (LinkState.GONE, "the host key has changed\x1b[2J")
        elif self.host.name.startswith(MISSING):
            outcome = (LinkState.UNREACHABLE, "connection timed out")
        self.reactor.call_later(0, functools.partial(self._opened, *outcome))

    def _opened(self, state: LinkState, reason: str) -> None:
        self.state = state
        self.context.listener.link_changed(self.host.name, state, reason)
        self._sample()

    def _sample(self) -> None:
        if not self._is_cut and not self._is_closed and self.state is LinkState.READY:
            self._report("samples", (self.host.name, self.machine.samples()))
        self.reactor.call_later(SAMPLE_S, self._sample)

    def _ask(self, request: Callable[[], None]) -> None:
        self._to_host.append(request)
        self.reactor.call_later(0, self._pump_host)

    def _pump_host(self) -> None:
        while self._to_host and not self._is_cut and self.state is not LinkState.GONE:
            self._to_host.popleft()()

    def prepare(self, process_id: int, order: Order) -> None:
        self._ask(functools.partial(self.machine.prepare, process_id, order))

    def command(self, process_id: int, command: MachineCommand) -> None:
        self._ask(functools.partial(self.machine.command, process_id, command))

    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None:
        self._ask(functools.partial(self.machine.signal, process_id, signum, by_user))

    def write_stdin(self, process_id: int, data: bytes) -> None:
        self._ask(functools.partial(self.machine.write_stdin, process_id, data))

    def pause(self, paused: bool) -> None:
        self._ask(functools.partial(self.machine.pause, paused))

    def finish(self, *, at_once: bool) -> None:
        if at_once and self._is_cut:
            return
        self._ask(functools.partial(self._finish, at_once))

    def _finish(self, at_once: bool) -> None:
        self._is_finishing = True
        self.machine.stop_all(MachineCommand.SKIP_GRACE if at_once else MachineCommand.STOP)
        self._machine_idle()

    def _machine_idle(self) -> None:
        if self._is_finishing and self.machine.is_idle:
            self._is_finishing = False
            self._report("finished", ())

    def detach(self) -> None:
        raise OSError("a loopback link cannot")

    def close(self) -> None:
        self._is_closed = True
        self.machine.close()
