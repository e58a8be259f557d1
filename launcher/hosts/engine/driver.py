"""Drives the processes of a run, those on other hosts too."""

from __future__ import annotations

import errno
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.events import Outcome
from launcher.base.model.record import replace
from launcher.base.model.run_events import Sample
from launcher.base.text import escape
from launcher.hosts.engine.hosts_backlog import HostsBacklog
from launcher.hosts.engine.link import LinkState
from launcher.hosts.engine.remote_host import RemoteChild, RemoteHost, host_of
from launcher.hosts.engine.replica import STARTS, Replica
from launcher.hosts.file.order_words import folder_there, words_there
from launcher.run.processes.machine_events import (
    Action,
    Escalate,
    Exited,
    MachineAction,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
    ReportStuck,
    Signal,
    SignalSent,
    SpawnError,
)
from launcher.run.processes.process_driver import ProcessDriver

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.hosts.engine.fleet import Fleet
    from launcher.run.driven_run import DrivenRun
    from launcher.run.processes.process import Process

_KILLED = -9  # the return code of a process that was lost with its host


class HostsDriver(ProcessDriver):
    """A ProcessDriver that also drives processes on the hosts of a `fleet`; a LinkListener.

    It sends commands there. What it reports of such a process is what its host has reported.
    """

    def __init__(self, run: DrivenRun, fleet: Fleet) -> None:
        super().__init__(run)
        self._fleet = fleet
        self._remote: dict[int, Process] = {}
        self._replicas: dict[int, Replica] = {}
        self._queued: dict[int, MachineCommand] = {}  # starts that are held back
        self._backlog: HostsBacklog | None = None
        run.reader.on_pause = fleet.pause

    # ---- commands

    def place(self, process: Process, *, merge: bool) -> None:
        """Find the host of a new process, and send the order; before its first start."""
        host = self._fleet.host_of(process.spec)
        if host is None:
            return
        process.host = host
        host.processes.append(process)
        replica = Replica(process.spec.restart, process.spec.stop)
        process.machine = self._replicas[process.process_id] = replica
        self._remote[process.process_id] = process
        try:
            order = self._fleet.order(process.spec, host, merge=merge)
            order = replace(order, number=process.number)
        except LauncherError as error:
            replica.refusal = (errno.EINVAL, error.message)
            return
        process.words_there = words_there(host.host, order)
        process.folder_there = folder_there(order, host.host)
        host.link.prepare(process.process_id, order)

    def advance(self, process: Process, event: MachineEvent) -> None:
        if process.host is None:
            super().advance(process, event)
        elif isinstance(event, MachineCommand):
            # The terminal's Ctrl-C has reached nobody there.
            event = MachineCommand.STOP if event is MachineCommand.INTERRUPTED else event
            self._command(process, host_of(process), event)

    def _command(self, process: Process, host: RemoteHost, command: MachineCommand) -> None:
        if process.is_abandoned:
            return
        replica = self._replicas[process.process_id]
        refusal = (errno.EHOSTDOWN, host.name) if host.is_gone else replica.refusal
        if refusal is not None:
            if command in STARTS:
                self._refuse(process, replica, command, refusal)
        elif self._withdraws(process, replica, command):
            return
        elif command in STARTS:
            replica.wants_start()
            self._queued[process.process_id] = command
            self.pass_on(process)
        else:
            host.link.command(process.process_id, command)

    def refuse(self, process: Process, number: int, what: str) -> None:
        if process.host is None:
            super().refuse(process, number, what)
            return
        replica, command = self._replicas[process.process_id], self._queued.pop(process.process_id)
        replica.withdraw()
        self._refuse(process, replica, command, (number, what))

    def _refuse(
        self, process: Process, replica: Replica, command: MachineCommand, refusal: tuple[int, str]
    ) -> None:
        """A start fails here: it is not sent to the host."""
        now = self._reactor.now()
        replica.handle(command, now)
        self._reports.refused(process, *refusal)
        self._carry_out(process, replica.handle(SpawnError(*refusal), now), now)
        self._reactor.call_later(0, self._run.idle)

    def _withdraws(self, process: Process, replica: Replica, command: MachineCommand) -> bool:
        """Whether the command stops a process whose start is queued; then it is not started."""
        is_stop = command in (
            MachineCommand.STOP,
            MachineCommand.USER_STOP,
            MachineCommand.SKIP_GRACE,
        )
        if not is_stop or not self._withdraw(process):
            return False
        replica.withdraw()
        replica.is_held = replica.is_held or command is MachineCommand.USER_STOP
        self._reports.cancelled(process)
        self._run.cancelled(process)
        self._run.idle()
        return True

    def spawn(self, process: Process) -> None:
        """The turn of a start has come."""
        if process.host is None:
            super().spawn(process)
            return
        command = self._queued.pop(process.process_id)
        host_of(process).link.command(process.process_id, command)

    def signal(self, process: Process, signum: int, *, by_user: bool = False) -> None:
        if process.host is None:
            super().signal(process, signum, by_user=by_user)
        elif process.child is not None:
            host_of(process).link.signal(process.process_id, signum, by_user=by_user)

    # ---- what a link reports

    def event(
        self, process_id: int, event: MachineEvent, at_s: float, pid: int, left_s: float | None
    ) -> None:
        process, replica = self._remote[process_id], self._replicas[process_id]
        host = host_of(process)
        if host.is_gone or process.is_abandoned:
            return  # its end has been reported
        host.events += 1
        if self._backlog is not None:
            self._backlog.flush()
        self._announce(process, host, event, at_s, pid)
        self._carry_out(process, replica.follow(event, at_s, left_s), at_s)
        if event is MachineCommand.STARTED:
            self._run.started(process, pid)
        elif event is MachineCommand.START_CANCELLED:
            self._run.cancelled(process)
        self._run.idle()

    def _announce(
        self, process: Process, host: RemoteHost, event: MachineEvent, at_s: float, pid: int
    ) -> None:
        """What is reported before the state machine is asked."""
        match event:
            case MachineCommand.STARTED:
                process.child = RemoteChild(pid, process.process_id, host)
                self._count_start(process, pid, at_s)
            case MachineCommand.START_CANCELLED:
                self._reports.cancelled(process, at_s)
            case SpawnError(errno=number, what=what):
                self._reports.refused(process, number, what, at_s)
            case SignalSent(signum=signum):
                self._reports.signalled(process, _pid_of(process), signum, at_s)
            case Exited():
                self._reader.drain(process)

    def _carry_out(self, process: Process, actions: Sequence[Action], at_s: float) -> None:
        """The reporting part of the actions; the host carries out the rest."""
        for action in actions:
            match action:
                case Signal(signum=signum):
                    self._reports.signalled(process, _pid_of(process), signum, at_s)
                case Escalate():
                    self._reports.escalated(process, action)
                case ReportStuck(waited_s=waited_s):
                    how = f"on {process.host_name}"
                    self._reports.stuck(process, _pid_of(process), waited_s, how, at_s)
                case ReportExit():
                    self._ended(process, action, at_s)
                case MachineAction():
                    pass

    def adopted(
        self, process_id: int, state: ProcessState, pid: int, since_s: float, restarts: int
    ) -> None:
        process = self._remote[process_id]
        self._replicas[process_id].adopt(state, since_s, restarts)
        process.history.starts = restarts + 1
        if pid > 0:
            process.child = RemoteChild(pid, process_id, host_of(process))
        age_s = self._reactor.now() - since_s
        self._reports.adopted(process, pid, state, age_s, restarts)
        self._run.idle()

    def output(self, process_id: int, stream: str, data: bytes, at_s: float) -> None:
        host = host_of(self._remote[process_id])
        if host.state is LinkState.UNREACHABLE:  # it is being caught up with
            host.lines += data.count(b"\n")
        if self._backlog is not None:
            self._backlog.add(host.name, (process_id, stream, data, at_s))
        else:
            self._show(process_id, stream, data, at_s)

    def _show(self, process_id: int, stream: str, data: bytes, at_s: float) -> None:
        self._reader.feed(self._remote[process_id], stream, data, at_s)

    def begin_with(self, lines: int, hosts: Iterable[str]) -> None:
        """The run goes on: begin with so many of its last lines on these hosts."""
        self._backlog = HostsBacklog(lines, hosts, self._reactor, self._show)

    def past_complete(self, host: str) -> None:
        if self._backlog is not None:
            self._backlog.complete(host)

    def show_past(self) -> None:
        """Show all that is held back: nothing more comes."""
        if self._backlog is not None:
            self._backlog.close()

    def dropped(self, host: str, lines: int) -> None:
        self._fleet.named(host).dropped += lines

    def link_changed(self, host: str, state: LinkState, reason: str) -> None:
        if state is LinkState.GONE and self._backlog is not None:
            self._backlog.complete(host)
            self._backlog.flush()
        self._fleet.link_changed(self._fleet.named(host), state, escape(reason, keep=""))

    def run_ended(self, host: str, operator: str) -> None:
        self._fleet.run.shutdown.stop(f"{escape(operator, keep='')} has ended the run on {host}")

    def warn(self, host: str, text: str) -> None:
        self._run.log.warn(f"{host}: {escape(text, keep='')}")

    def finished(self, host: str, leftovers: Sequence[str], *, killed: bool) -> None:
        shown = [escape(text, keep="") for text in leftovers]
        self._fleet.finished(self._fleet.named(host), shown, killed=killed)

    def samples(self, host: str, samples: Mapping[int, Mapping[str, Any]]) -> None:
        self._fleet.named(host).samples = {
            self._remote[process_id].name: Sample(**fields)
            for process_id, fields in samples.items()
            if process_id in self._remote
        }

    def lose(self, host: RemoteHost, at_s: float) -> list[str]:
        """The host is gone: its processes have ended; their names."""
        lost = host.pending
        for process in lost:
            replica = self._replicas[process.process_id]
            self._reader.drain(process)
            if replica.is_only_wanted:
                replica.withdraw()
                self._refuse(process, replica, MachineCommand.START, (errno.EHOSTDOWN, host.name))
                continue
            outcome = Outcome(returncode=_KILLED, lost_with=host.name)
            self._carry_out(process, replica.lose(outcome, at_s), at_s)
        self._run.idle()
        return [process.name for process in lost]


def _pid_of(process: Process) -> int:
    return -1 if process.child is None else process.child.pid
