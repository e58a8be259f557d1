"""Sends signals, and lines of standard input, to processes for users."""

from __future__ import annotations

import signal

from launcher.base.model.record import replace
from launcher.base.model.run_events import Asked
from launcher.base.model.spec import RestartMode
from launcher.posix.reactor import Reactor
from launcher.run.logs.run_log import RunLog
from launcher.run.processes.machine_events import POLITE, MachineCommand
from launcher.run.processes.process import Process
from launcher.run.processes.process_driver import ProcessDriver
from launcher.run.requests.request_result import Kind, Result

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from launcher.run.requests.request_queue import Done

# The kernel has no event for a process that is suspended or resumed: poll while a user waits.
SUSPEND_POLL_S = 0.02
SUSPEND_TIMEOUT_S = 1.0
SIGNAL_TIMEOUT_S = 1.0  # wait for an exit after a single signal
FATAL_BY_DEFAULT = POLITE | {
    signal.SIGKILL,
    signal.SIGABRT,
    signal.SIGSEGV,
    signal.SIGUSR1,
    signal.SIGUSR2,
    signal.SIGALRM,
    signal.SIGPIPE,
    signal.SIGBUS,
    signal.SIGFPE,
    signal.SIGILL,
}


class ProcessSignals:
    """Acts at once, and calls `done(result)` when the effect is known."""

    def __init__(self, reactor: Reactor, driver: ProcessDriver, log: RunLog) -> None:
        self._reactor = reactor
        self._driver = driver
        self._log = log
        self._checks: list[Callable[[], bool]] = []  # of signals; each returns whether it is over

    def kill(self, process: Process, signum: int, done: Done, *, as_crash: bool = False) -> None:
        """Send it only this signal; if it exits by it, it is not restarted, unless `as_crash`."""
        child = process.child
        if refusal := _refusal(process):
            done(refusal)
            return
        assert child is not None
        if signum == 0:
            done(Result(process.name, Kind.EXISTS, done=True, pid=child.pid))
            return
        self._log.note(Asked("kill", int(signum)), process)
        sent = Result(process.name, Kind.SIGNALLED, done=True, signum=signum)
        began_s = self._reactor.now()
        self._driver.signal(process, signum, by_user=not as_crash)
        if signum not in FATAL_BY_DEFAULT:
            done(sent)
            return

        def is_over() -> bool:
            elapsed_s = self._reactor.now() - began_s
            if process.child is not child:
                end = None if process.last_end is None else process.last_end.outcome
                ended = replace(sent, kind=Kind.ENDED_BY_SIGNAL, elapsed_s=elapsed_s, exit=end)
                done(replace(ended, restart_disabled=may_restart(process) and not as_crash))
            elif lost := unreachable(process, Kind.LINK_LOST):
                done(lost)
            elif elapsed_s >= SIGNAL_TIMEOUT_S:
                done(replace(sent, kind=Kind.SURVIVED))
            else:
                return False
            return True

        if not is_over():
            self._checks.append(is_over)
            self._reactor.call_later(SIGNAL_TIMEOUT_S, self.check)

    @property
    def is_waiting(self) -> bool:
        """Whether the effect of a signal is not known yet."""
        return bool(self._checks)

    def check(self) -> None:
        """A process may have exited: complete what waits for that."""
        checks, self._checks = self._checks, []
        self._checks += [check for check in checks if not check()]

    def suspend(self, process: Process, done: Done) -> None:
        """Suspend it, with its whole group, until it is resumed."""
        if process.machine.is_suspended and process.is_halted:
            done(Result(process.name, Kind.ALREADY_SUSPENDED, done=False))
        elif refusal := _refusal(process):
            done(refusal)
        else:
            self._log.note(Asked("pause"), process)
            self._driver.advance(process, MachineCommand.SUSPEND)
            self._await(process, Kind.SUSPENDED, signal.SIGSTOP, done)

    def resume(self, process: Process, done: Done) -> None:
        if process.child is not None and not process.is_halted:
            done(Result(process.name, Kind.NOT_SUSPENDED, done=False))
        elif refusal := _refusal(process):
            done(refusal)
        else:
            self._log.note(Asked("resume"), process)
            self._driver.advance(process, MachineCommand.RESUME)
            self._await(process, Kind.RESUMED, signal.SIGCONT, done)

    def _await(self, process: Process, kind: Kind, signum: signal.Signals, done: Done) -> None:
        child, until_s = process.child, self._reactor.now() + SUSPEND_TIMEOUT_S
        result = Result(process.name, kind, done=True, signum=signum)

        def check() -> None:
            if process.child is not child:
                done(Result(process.name, Kind.ENDED, done=False))
            elif process.is_halted is (kind is Kind.SUSPENDED):
                done(result)
            elif self._reactor.now() >= until_s:
                done(replace(result, kind=Kind.WITHOUT_EFFECT, done=False))
            else:
                self._reactor.call_later(SUSPEND_POLL_S, check)

        check()

    def send(self, process: Process, data: bytes, done: Done) -> None:
        """Write to its standard input."""
        if refusal := _refusal(process):
            done(refusal)
            return
        if process.spec.members:
            done(Result(process.name, Kind.NO_INPUT, done=False))
            return
        assert process.child is not None
        try:
            written = process.child.write_stdin(data)
        except OSError as error:
            errno = error.errno or 0
            done(Result(process.name, Kind.NOT_WRITTEN, done=False, errno=errno))
            return
        is_all = written == len(data)
        kind = Kind.WRITTEN if is_all else Kind.PARTLY_WRITTEN
        done(Result(process.name, kind, done=is_all, written=written, size=len(data)))


def not_running(process: Process) -> Result:
    return Result(process.name, Kind.NOT_RUNNING, done=False, state=process.machine.state)


def unreachable(process: Process, kind: Kind = Kind.UNREACHABLE) -> Result | None:
    """The answer for a process on a host that cannot be reached; None if it can."""
    host = process.host
    if host is not None and host.is_gone and kind is Kind.UNREACHABLE:
        return Result(process.name, Kind.HOST_LOST, done=False, host=host.name)
    if host is None or host.unreachable_s is None:
        return None
    is_accepted = kind is Kind.STOP_WAITS
    silent_s = host.unreachable_s
    return Result(process.name, kind, done=is_accepted, host=host.name, elapsed_s=silent_s)


def may_restart(process: Process) -> bool:
    return process.spec.restart.mode is not RestartMode.NEVER


def _refusal(process: Process) -> Result | None:
    return not_running(process) if process.child is None else unreachable(process)
