"""Starts, stops and signals single processes for users, and reports the results as data."""

from __future__ import annotations

import enum
import signal
from collections.abc import Callable

from launcher.engine.logs.run_log import RunLog
from launcher.engine.machine import POLITE, Command, Ended, ProcessState
from launcher.engine.posix.reactor import Reactor
from launcher.engine.process import Process
from launcher.engine.process_driver import ProcessDriver
from launcher.engine.shutdown import Shutdown
from launcher.model.events import Outcome, signal_name
from launcher.model.record import Record, replace
from launcher.model.spec import RestartMode

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


class Kind(enum.Enum):
    """The outcome of a request; the comments name the fields of `Result` that are set."""

    NOT_RUNNING = enum.auto()  # state
    ENDED = enum.auto()
    STUCK = enum.auto()
    # stop and restart
    STOPPED = enum.auto()  # elapsed_s, signum, exit
    RESTART_CANCELLED = enum.auto()
    START_CANCELLED = enum.auto()
    # start and restart
    RUN_STOPPING = enum.auto()
    QUEUED = enum.auto()
    ALREADY_RUNNING = enum.auto()  # pid
    STARTED = enum.auto()  # pid; of a restart old_pid and stopped
    START_FAILED = enum.auto()  # exit; of a restart stopped
    UNDER_DEBUGGER = enum.auto()  # it was not restarted for a change
    # signals
    EXISTS = enum.auto()  # pid
    SIGNALLED = enum.auto()  # signum
    SURVIVED = enum.auto()  # signum
    ENDED_BY_SIGNAL = enum.auto()  # elapsed_s, signum, exit
    ALREADY_SUSPENDED = enum.auto()
    NOT_SUSPENDED = enum.auto()
    SUSPENDED = enum.auto()  # signum
    RESUMED = enum.auto()  # signum
    WITHOUT_EFFECT = enum.auto()  # signum
    # standard input
    WRITTEN = enum.auto()  # written
    PARTLY_WRITTEN = enum.auto()  # written, size
    NOT_WRITTEN = enum.auto()  # errno
    # processes on other hosts: host, elapsed_s since it was heard of last
    UNREACHABLE = enum.auto()  # nothing was requested
    STOP_WAITS = enum.auto()  # until the host can be reached
    LINK_LOST = enum.auto()  # after it was requested
    HOST_LOST = enum.auto()  # for ever: it cannot be started; host


class Result(Record):
    """The outcome of a request for one process, and whether it was `done`.

    `stopped` is the result of the first half of a restart. After an exit, `runs_again`: it was
    started again meanwhile; `restart_disabled`: its restart policy does not apply, because a user
    has stopped it.
    """

    process: str
    kind: Kind
    done: bool
    state: ProcessState | None = None
    elapsed_s: float = 0.0
    signum: int = 0
    exit: Outcome | None = None
    pid: int | None = None
    old_pid: int | None = None
    stopped: Result | None = None
    written: int = 0
    size: int = 0
    errno: int = 0
    runs_again: bool = False
    restart_disabled: bool = False
    host: str = ""


Done = Callable[[Result], None]
ResultCheck = Callable[[], "Result | None"]


class ProcessControl:
    """Carries out requests for single processes; calls `done(result)` when they are complete."""

    def __init__(
        self, reactor: Reactor, driver: ProcessDriver, log: RunLog, shutdown: Shutdown
    ) -> None:
        self._reactor = reactor
        self._driver = driver
        self._log = log
        self._shutdown = shutdown
        self._waiting: list[tuple[ResultCheck, Done, Process]] = []

    # ---- stop and start

    def stop(self, process: Process, done: Done) -> None:
        """Stop it by its stop policy; it may be started again."""
        machine, life, began_s = process.machine, process.last_end, self._reactor.now()
        if not machine.is_pending:
            done(_not_running(process))
            return
        self._note("stop", process)
        process.user_stops += 1
        was_alive = machine.state.is_alive
        self._driver.advance(process, Command.USER_STOP)
        if waits := _unreachable(process, Kind.STOP_WAITS):
            done(waits)
            return
        if not was_alive:
            done(Result(process.name, Kind.RESTART_CANCELLED, done=True))
            return

        def check() -> Result | None:
            if machine.is_stuck:
                return Result(process.name, Kind.STUCK, done=False)
            if machine.state.is_alive and process.last_end is life:
                return None
            if process.last_end is life:
                result = Result(process.name, Kind.START_CANCELLED, done=True)
            else:
                result = self._stopped(process, began_s)
            runs_again = machine.state.is_alive
            is_disabled = not runs_again and _may_restart(process)
            return replace(result, runs_again=runs_again, restart_disabled=is_disabled)

        self._when(check, done, process)

    def _stopped(self, process: Process, began_s: float) -> Result:
        return Result(
            process=process.name,
            kind=Kind.STOPPED,
            done=True,
            elapsed_s=self._reactor.now() - began_s,
            signum=process.machine.stop_signal,
            exit=None if process.last_end is None else process.last_end.outcome,
        )

    def start(self, process: Process, done: Done) -> None:
        """Start it if it is not running; its restarts are counted from 0 again."""
        state, name = process.machine.state, process.name
        if self._shutdown.has_begun:
            done(Result(name, Kind.RUN_STOPPING, done=False))
        elif refusal := _unreachable(process):
            done(refusal)
        elif state is ProcessState.STOPPING:

            def start(ended: Result) -> None:
                is_over = ended.kind in (Kind.STUCK, Kind.LINK_LOST)
                done(ended) if is_over else self.start(process, done)

            self._when(lambda: _end_of(process), start, process)
        elif _is_queued(process):
            if not self._skip_wait(process, done):
                done(Result(name, Kind.QUEUED, done=False))
        elif state.is_alive:
            done(Result(name, Kind.ALREADY_RUNNING, done=False, pid=_pid_of(process)))
        else:
            self._note("start", process)
            self._start(process, done)

    def _skip_wait(self, process: Process, done: Done) -> bool:
        """Start a process that waits for others; False if it does not."""
        life = process.last_end
        if not self._driver.skip_wait(process):
            return False
        self._note("start", process)
        self._await_start(process, done, life)
        return True

    def _start(
        self,
        process: Process,
        done: Done,
        stopped: Result | None = None,
        old_pid: int | None = None,
    ) -> None:
        life = process.last_end
        self._driver.advance(process, Command.USER_START)
        self._await_start(process, done, life, stopped, old_pid)

    def _await_start(
        self,
        process: Process,
        done: Done,
        life: Ended | None,
        stopped: Result | None = None,
        old_pid: int | None = None,
    ) -> None:
        name = process.name

        def check() -> Result | None:
            if process.machine.state is ProcessState.STARTING:
                return None  # it is queued, or its limits are still being set
            last = process.last_end
            if process.child is not None:
                started = Result(name, Kind.STARTED, done=True, pid=process.child.pid)
                return replace(started, old_pid=old_pid, stopped=stopped)
            if last is life or last is None:
                return Result(name, Kind.START_CANCELLED, done=False, stopped=stopped)
            failed = Result(name, Kind.START_FAILED, done=False, exit=last.outcome)
            return replace(failed, stopped=stopped)

        self._when(check, done, process)

    def restart(self, process: Process, done: Done) -> None:
        """Stop it if it runs, then start it; not if a user stops it meanwhile."""
        if not process.machine.state.is_alive:
            self.start(process, done)
            return
        if self._shutdown.has_begun:
            done(Result(process.name, Kind.RUN_STOPPING, done=False))
            return
        if refusal := _unreachable(process):
            done(refusal)
            return
        if _is_queued(process):
            if not self._skip_wait(process, done):
                self._driver.begin_again(process)
                done(Result(process.name, Kind.QUEUED, done=True))
            return
        self._note("restart", process)
        old_pid, began_s, stops = _pid_of(process), self._reactor.now(), process.user_stops

        def start(ended: Result) -> None:
            if ended.kind in (Kind.STUCK, Kind.LINK_LOST):
                done(ended)
                return
            stopped = self._stopped(process, began_s)
            if process.user_stops != stops:
                done(stopped)
                return
            if process.host is not None and process.host.is_gone:
                lost = Result(process.name, Kind.HOST_LOST, done=False, host=process.host.name)
                done(replace(lost, stopped=stopped))
                return
            if self._shutdown.has_begun:
                done(Result(process.name, Kind.RUN_STOPPING, done=False, stopped=stopped))
                return
            self._start(process, done, stopped, old_pid)

        self._driver.advance(process, Command.USER_STOP)
        self._when(lambda: _end_of(process), start, process)

    # ---- signals

    def kill(self, process: Process, signum: int, done: Done, *, as_crash: bool = False) -> None:
        """Send it only this signal; if it exits by it, it is not restarted, unless `as_crash`."""
        child, name, began_s = process.child, process.name, self._reactor.now()
        if child is None:
            done(_not_running(process))
            return
        if refusal := _unreachable(process):
            done(refusal)
            return
        if signum == 0:
            done(Result(name, Kind.EXISTS, done=True, pid=child.pid))
            return
        self._note("kill", process, signal=signal_name(signum))
        self._driver.signal(process, signum, by_user=not as_crash)
        if signum not in FATAL_BY_DEFAULT:
            done(Result(name, Kind.SIGNALLED, done=True, signum=signum))
            return

        def check() -> Result | None:
            elapsed_s = self._reactor.now() - began_s
            if process.child is child:
                if elapsed_s < SIGNAL_TIMEOUT_S:
                    return None
                return Result(name, Kind.SURVIVED, done=True, signum=signum)
            return Result(
                process=name,
                kind=Kind.ENDED_BY_SIGNAL,
                done=True,
                elapsed_s=elapsed_s,
                signum=signum,
                exit=None if process.last_end is None else process.last_end.outcome,
                restart_disabled=_may_restart(process) and not as_crash,
            )

        self._when(check, done, process)
        self._reactor.call_later(SIGNAL_TIMEOUT_S, self.changed)

    def suspend(self, process: Process, done: Done) -> None:
        """Suspend it, with its whole group, until it is resumed."""
        is_suspended = process.machine.is_suspended and process.is_halted
        refusal = Kind.ALREADY_SUSPENDED if is_suspended else None
        self._suspend_or_resume(process, signal.SIGSTOP, refusal, done)

    def resume(self, process: Process, done: Done) -> None:
        refusal = None if process.is_halted else Kind.NOT_SUSPENDED
        self._suspend_or_resume(process, signal.SIGCONT, refusal, done)

    def _suspend_or_resume(
        self, process: Process, signum: signal.Signals, refusal: Kind | None, done: Done
    ) -> None:
        child, name = process.child, process.name
        if child is None or refusal is not None:
            done(Result(name, refusal, done=False) if child and refusal else _not_running(process))
            return
        if unreachable := _unreachable(process):
            done(unreachable)
            return
        is_suspending = signum == signal.SIGSTOP
        self._note("pause" if is_suspending else "resume", process)
        self._driver.advance(process, Command.SUSPEND if is_suspending else Command.RESUME)
        deadline_s = self._reactor.now() + SUSPEND_TIMEOUT_S

        def check() -> None:
            if process.child is not child:
                done(Result(name, Kind.ENDED, done=False))
            elif process.is_halted is is_suspending:
                kind = Kind.SUSPENDED if is_suspending else Kind.RESUMED
                done(Result(name, kind, done=True, signum=signum))
            elif self._reactor.now() >= deadline_s:
                done(Result(name, Kind.WITHOUT_EFFECT, done=False, signum=signum))
            else:
                self._reactor.call_later(SUSPEND_POLL_S, check)

        check()

    # ---- standard input

    def send(self, process: Process, data: bytes, done: Done) -> None:
        if process.child is None:
            done(_not_running(process))
            return
        if refusal := _unreachable(process):
            done(refusal)
            return
        try:
            written = process.child.write_stdin(data)
        except OSError as error:
            errno = error.errno or 0
            done(Result(process.name, Kind.NOT_WRITTEN, done=False, errno=errno))
            return
        is_all = written == len(data)
        kind = Kind.WRITTEN if is_all else Kind.PARTLY_WRITTEN
        done(Result(process.name, kind, done=is_all, written=written, size=len(data)))

    # ---- waiting

    def changed(self) -> None:
        """A process has started, exited or got stuck: complete requests that wait for it."""
        if self._waiting:
            self._reactor.call_later(0, self._check_waiting)

    def _when(self, check: ResultCheck, done: Done, process: Process) -> None:
        """Call `done` when `check` has a result, which may be now, or the process is cut off."""
        result = check() or _unreachable(process, Kind.LINK_LOST)
        if result is None:
            self._waiting.append((check, done, process))
        else:
            done(result)

    def _check_waiting(self) -> None:
        waiting, self._waiting = self._waiting, []
        for check, done, process in waiting:
            self._when(check, done, process)

    def _note(self, verb: str, process: Process, **details: object) -> None:
        self._log.note("asked", process, None, verb=verb, **details)


def _unreachable(process: Process, kind: Kind = Kind.UNREACHABLE) -> Result | None:
    """The answer for a process on a host that cannot be reached; None if it can."""
    host = process.host
    if host is not None and host.is_gone and kind is Kind.UNREACHABLE:
        return Result(process.name, Kind.HOST_LOST, done=False, host=host.name)
    if host is None or host.unreachable_s is None:
        return None
    is_accepted = kind is Kind.STOP_WAITS
    silent_s = host.unreachable_s
    return Result(process.name, kind, done=is_accepted, host=host.name, elapsed_s=silent_s)


def _not_running(process: Process) -> Result:
    return Result(process.name, Kind.NOT_RUNNING, done=False, state=process.machine.state)


def _end_of(process: Process) -> Result | None:
    if process.machine.is_stuck:
        return Result(process.name, Kind.STUCK, done=False)
    return None if process.machine.state.is_alive else Result(process.name, Kind.ENDED, done=True)


def _pid_of(process: Process) -> int | None:
    return None if process.child is None else process.child.pid


def _is_queued(process: Process) -> bool:
    """Whether it waits for its start, because starts are paced."""
    return process.machine.state is ProcessState.STARTING and process.child is None


def _may_restart(process: Process) -> bool:
    return process.spec.restart.mode is not RestartMode.NEVER
