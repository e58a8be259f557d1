"""The host's side: a separate process driver, which reports to whoever listens."""

from __future__ import annotations

import functools
import os
import tempfile
from collections.abc import Callable, Mapping
from typing import Any, cast

from launcher.base.model.spec import ProcessSpec
from launcher.hosts.agent.forwarder import Forwarder
from launcher.hosts.engine.frames import STREAMS
from launcher.hosts.engine.replica import ReportingMachine
from launcher.hosts.file.order import Order
from launcher.hosts.file.resolution import resolve
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import Child, StartSettings, start
from launcher.run.processes.machine_events import MachineCommand, MachineEvent, SignalSent
from launcher.run.processes.process import Process
from launcher.run.processes.process_driver import ProcessDriver

# event, process_id, at_s, pid, left_s; or output: stream, process_id, data, at_s
Report = tuple[str, tuple[Any, ...]]


class Machine:
    """`report(method, arguments)` is called as for a `LinkListener`."""

    def __init__(
        self,
        reactor: Reactor,
        environment: Mapping[str, str],
        report: Callable[[str, tuple[Any, ...]], None],
    ) -> None:
        self.reactor = reactor
        self.processes: dict[int, Process] = {}
        self.on_idle: Callable[[], None] = lambda: None
        self._orders: dict[int, Order] = {}
        self._environment = environment
        self._report = report
        self._forwarder = Forwarder(reactor, self.processes.values(), self._forward)
        self.reader, self.log = self._forwarder, cast(Any, _Quiet())
        self.spawner, self.stages = self, ()
        self._driver = ProcessDriver(cast(Any, self))
        self._files = tempfile.TemporaryDirectory(prefix="loopback-")

    # ---- requests

    def prepare(self, process_id: int, order: Order) -> None:
        found = resolve(order, f"{self._files.name}/{process_id}", self._environment)
        spec = ProcessSpec(
            name=order.name,
            label=order.label,
            argv=found.argv,
            env=found.env,
            cwd=found.cwd,
            shell=order.shell,
            emulate_tty=order.emulate_tty,
            restart=order.restart,
            stop=order.stop,
            limits=order.limits,
        )
        process = Process(process_id, spec, number=0, prefix=b"")
        handled = functools.partial(self._handled, process)
        process.machine = ReportingMachine(order.restart, order.stop, handled)
        self.processes[process_id] = process
        self._orders[process_id] = order

    def command(self, process_id: int, command: MachineCommand) -> None:
        self._driver.advance(self.processes[process_id], command)

    def signal(self, process_id: int, signum: int, by_user: bool) -> None:
        process = self.processes[process_id]
        if process.child is None:
            process.machine.handle(SignalSent(signum, by_user=by_user), self.reactor.now())
        else:
            self._driver.signal(process, signum, by_user=by_user)

    def write_stdin(self, process_id: int, data: bytes) -> None:
        self._driver.write_stdin(self.processes[process_id], data)

    def pause(self, paused: bool) -> None:
        self._forwarder.pause(paused)

    def stop_all(self, command: MachineCommand = MachineCommand.STOP) -> None:
        for process in self.processes.values():
            self._driver.advance(process, command)

    def samples(self) -> dict[int, dict[str, Any]]:
        """Invented figures of what runs."""
        usage = {"cpu_percent": 12.5, "rss_bytes": 9_000_000, "uss_bytes": 5_000_000}
        counts = {"threads": 3, "fds": 4, "processes": 1}
        return {
            process.process_id: {"pid": process.child.pid, **usage, **counts}
            for process in self.processes.values()
            if process.child is not None
        }

    @property
    def is_idle(self) -> bool:
        return not any(process.machine.is_pending for process in self.processes.values())

    def kill(self) -> None:
        """The machine loses its power."""
        for process in self.processes.values():
            if process.timer is not None:
                process.timer.cancel()
            if process.child is not None:
                process.child.signal_group(9)
                self._driver.release(process)

    def close(self) -> None:
        self._files.cleanup()

    # ---- events

    def _forward(self, process_id: int, stream: int, chunk: bytes) -> None:
        self._report("output", (process_id, STREAMS[stream], chunk, self.reactor.now()))

    def _handled(
        self, process: Process, event: MachineEvent, now: float, left_s: float | None
    ) -> None:
        pid = -1 if process.child is None else process.child.pid
        self._report("event", (process.process_id, event, now, pid, left_s))

    # ---- what the driver needs of a run

    def spawn(self, process: Process) -> Child:
        merge = self._orders[process.process_id].merge
        return start(process.spec, StartSettings(process.spec.env, merge))

    def idle(self) -> None:
        self.on_idle()

    def __getattr__(self, name: str) -> Callable[..., None]:
        if name not in ("started", "ended", "cancelled", "before_kill", "may_have_left"):
            raise AttributeError(name)
        return lambda *args, **more: None


class _Quiet:
    """Takes the place of the RunLog."""

    def report(self, *args: object) -> None:
        pass

    def note(self, *args: object, **more: object) -> None:
        pass


def environment() -> dict[str, str]:
    return dict(os.environ)
