"""Supervisor: carries out what the interpreter asks for, with real processes in real time."""

from __future__ import annotations

import errno
import functools
import os
import signal
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from launcher.engine import report
from launcher.engine.guard import Guard
from launcher.engine.machine import (
    Ended,
    Escalate,
    Exited,
    Hurry,
    MachineEvent,
    ProcessState,
    Signal,
    Spawn,
    SpawnError,
    Start,
    Started,
    Stop,
    Tick,
)
from launcher.engine.process import Process, child_environment
from launcher.engine.reactor import Reactor, Timer
from launcher.engine.relay import Relay
from launcher.engine.remnants import Remnants
from launcher.engine.runfolder import RunFolder
from launcher.engine.screen import Screen
from launcher.engine.spawn import spawn
from launcher.engine.sweep import RUN_ID_VARIABLE
from launcher.errors import ExitCode
from launcher.model.events import (
    CallLater,
    CancelTimer,
    Effect,
    Event,
    LogMessage,
    ProcessExited,
    ProcessOutput,
    ProcessStarted,
    RequestShutdown,
    SignalProcess,
    SignalReceived,
    SpawnFailed,
    StartProcess,
    StopProcess,
    TimerFired,
    WriteStdin,
)

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WAITING_NOTE_S = 1.0  # a stop that takes longer says for whom it waits
LAST_LINES = 10  # of the process that died first, in the summary
LAST_WORDS_S = 2.0  # how long a slow reader of our output is waited for at the end


class Core(Protocol):
    """What drives the run: `launcher.interpreter.Interpreter`, or a test's own."""

    def start(self) -> Sequence[Effect]:
        """The effects of the launch file's static part."""

    def handle(self, event: Event) -> Sequence[Effect]:
        """The effects of what happened."""

    def watches_output(self, process_id: int) -> bool:
        """Whether ProcessOutput is wanted for this process."""


class Supervisor:
    """One run, from the first process to the last. `run()` returns the exit code."""

    def __init__(
        self,
        core: Core,
        *,
        env: Mapping[str, str],
        reactor: Reactor,
        screen: Screen,
        run_id: str,
        make_guard: Callable[[str], Guard] = Guard,
    ) -> None:
        self._core = core
        self._env = env
        self._reactor = reactor
        self._screen = screen
        self._run_id = run_id
        self._make_guard = make_guard
        self._guard: Guard | None = None
        self._processes: dict[int, Process] = {}
        self._timers: dict[int, Timer] = {}
        self._inbox: deque[Event] = deque()
        self._busy = False
        self._stopping = False
        self._stop_signal: int | None = None
        self._first_death: str | None = None
        self._killed = False
        self._remnants: Remnants | None = None
        self._folder = RunFolder(env, lambda text: screen.log("WARNING", "launch", text))
        self._relay = Relay(
            reactor,
            screen,
            self._folder,
            watched=lambda process: core.watches_output(process.process_id),
            watcher=self._output,
        )
        screen.on_pressure = lambda pressed: self._relay.pause(pressed, self._processes.values())
        # Not at once: it may be found out in the middle of reporting on a process.
        screen.on_closed = lambda: self._later(self._output_closed)

    # ---- the run

    def run(self) -> ExitCode:
        """Start, serve, stop. Whatever happens, nothing is left when this returns."""
        self._reactor.on_signals(STOP_SIGNALS, self._signalled)
        try:
            if self._folder.path is not None:
                self._say("INFO", "launch", f"All log files can be found below {self._folder.path}")
            self._begin()
            self._finish_if_done()
            self._reactor.run()
            if self._first_death is not None:
                self._say("ERROR", "launch", self._first_death)
        finally:
            self._clean_up()
        return self._exit_code()

    def _begin(self) -> None:
        """Carry out the static part as a whole before the first answer is handled."""
        self._busy = True
        self._carry_out(self._core.start())
        self._busy = False
        self._pump()
        self._later(self._write_plan)
        self._later(self._folder.prune)

    def _exit_code(self) -> ExitCode:
        unclean = self._first_death is not None or self._killed
        if not unclean:
            return ExitCode.OK
        if self._stop_signal is None:
            return ExitCode.PROCESS_FAILED
        is_interrupt = self._stop_signal == signal.SIGINT
        return ExitCode.INTERRUPTED if is_interrupt else ExitCode.TERMINATED

    def _clean_up(self) -> None:
        for process in self._processes.values():
            if process.child is not None:
                # Only after an error of our own: an orderly end has seen every child go.
                process.child.signal_group(signal.SIGKILL)
            self._forget_child(process)
        if self._guard is not None:
            self._guard.close()
        self._write_plan()
        self._note("finished", exit_code=int(self._exit_code()))
        self._screen.finish(LAST_WORDS_S)
        self._folder.close()

    def _later(self, callback: Callable[[], None]) -> None:
        self._reactor.call_later(0, callback)

    def _write_plan(self) -> None:
        self._folder.write_plan((p.spec for p in self._processes.values()), self._env)

    def _note(self, event: str, process: Process | None = None, **details: object) -> None:
        """An entry of the journal, written when this pass of the loop is done."""
        if self._folder.journal.is_empty:
            self._later(self._folder.journal.flush)
        name = {} if process is None else {"process": process.name}
        self._folder.journal.note(event, **name, **details)

    def _output_closed(self) -> None:
        self._stop_all("nobody reads our output any more")

    def _say(self, level: str, logger: str, text: str) -> None:
        self._screen.log(level, logger, text)
        self._folder.log(level, logger, text)

    def _tell(self, process: Process, line: report.Line) -> None:
        self._say(line.level, process.name, line.text)

    # ---- effects of the interpreter

    def _feed(self, event: Event) -> None:
        """Tell the interpreter, once what it asked for before has been carried out."""
        self._inbox.append(event)
        self._pump()

    def _pump(self) -> None:
        if self._busy:
            return  # whoever is busy, below us on the stack, goes on with the inbox
        self._busy = True
        while self._inbox:
            self._carry_out(self._core.handle(self._inbox.popleft()))
        self._busy = False

    def _carry_out(self, effects: Sequence[Effect]) -> None:
        for effect in effects:
            match effect:
                case StartProcess():
                    self._start(effect)
                case CallLater(timer_id=timer_id, delay_s=delay_s):
                    self._timers[timer_id] = self._reactor.call_later(
                        delay_s, functools.partial(self._fire, timer_id)
                    )
                case CancelTimer(timer_id=timer_id):
                    if timer_id in self._timers:
                        self._timers.pop(timer_id).cancel()
                case LogMessage(logger=logger, level=level, text=text):
                    self._say(level, logger, text)
                case RequestShutdown():
                    self._stop_all(effect.reason)
                case SignalProcess() | StopProcess() | WriteStdin():
                    process = self._processes.get(effect.process_id)
                    if process is not None:  # else: a stop came before its start
                        self._steer(process, effect)

    def _steer(self, process: Process, effect: SignalProcess | StopProcess | WriteStdin) -> None:
        match effect:
            case SignalProcess(signum=signum):
                self._signal(process, signum)
            case StopProcess():
                self._advance(process, Stop())
            case WriteStdin(data=data):
                self._write_stdin(process, data)

    def _start(self, effect: StartProcess) -> None:
        number = len(self._processes)
        prefix = self._screen.prefix(effect.spec.name, number)
        process = Process(effect.process_id, effect.spec, number=number, prefix=prefix)
        self._processes[effect.process_id] = process
        self._advance(process, Start())

    def _signal(self, process: Process, signum: int) -> None:
        if process.child is not None:
            self._tell(process, report.signalled(process.name, signum))
            self._note("signal", process, pid=process.child.pid, signal=int(signum))
            process.child.signal_group(signum)

    def _write_stdin(self, process: Process, data: bytes) -> None:
        if process.child is None:
            return
        try:
            process.child.write_stdin(data)
        except OSError as error:
            text = f"standard input takes nothing: {os.strerror(error.errno or 0)}"
            self._tell(process, report.Line("WARNING", text))

    def _fire(self, timer_id: int) -> None:
        self._timers.pop(timer_id, None)
        self._feed(TimerFired(timer_id=timer_id))
        self._finish_if_done()

    def _output(self, process: Process, stream: str, data: bytes) -> None:
        stream = "stdout" if stream == "both" else stream
        self._feed(ProcessOutput(process_id=process.process_id, stream=stream, data=data))

    # ---- one process

    def _advance(self, process: Process, event: MachineEvent) -> None:
        """Feed the machine, do what it says, and wake it at its deadline."""
        for action in process.machine.handle(event, self._reactor.now()):
            match action:
                case Spawn():
                    self._spawn(process)
                case Signal(signum=signum):
                    self._killed |= signum == signal.SIGKILL
                    self._signal(process, signum)
                case Escalate():
                    self._tell(process, report.escalated(process.name, action))
                case Ended():
                    self._report_end(process, action)
        self._set_timer(process)

    def _set_timer(self, process: Process) -> None:
        if process.timer is not None:
            process.timer.cancel()
            process.timer = None
        deadline = process.machine.deadline
        if deadline is not None:
            delay_s = deadline - self._reactor.now()
            process.timer = self._reactor.call_later(
                delay_s, functools.partial(self._tick, process)
            )

    def _tick(self, process: Process) -> None:
        self._advance(process, Tick())
        self._finish_if_done()

    def _spawn(self, process: Process) -> None:
        spec = process.spec
        path = self._folder.path
        try:
            process.child = spawn(
                spec,
                env=child_environment(
                    spec,
                    run_id_entry=(RUN_ID_VARIABLE, self._run_id),
                    log_dir=None if path is None else str(path),
                    colour=self._screen.colour,
                ),
                merge=process.streams_can_merge
                and not self._core.watches_output(process.process_id),
                terminal_size=_terminal_size(len(process.name) + 3),
            )
        except OSError as error:
            number = error.errno or errno.EIO
            self._tell(process, report.not_started(spec, number))
            self._note("not started", process, reason=os.strerror(number))
            self._advance(process, SpawnError(number))
            return
        child = process.child
        self._relay.attach(process)
        self._reactor.add_reader(child.pidfd, lambda: self._exited(process))
        if self._guard is None:
            # After the first spawn, since its start-up is nothing that a user should wait for.
            self._guard = self._make_guard(self._run_id)
        self._tell(process, report.started(child.pid))
        restarts = process.machine.restarts
        self._note("started", process, pid=child.pid, restarts=restarts)
        self._advance(process, Started(child.pid))
        self._feed(ProcessStarted(process_id=process.process_id, pid=child.pid))

    def _exited(self, process: Process) -> None:
        child = process.child
        assert child is not None
        if process.machine.may_restart:
            # What it leaves in its group would run beside its successor. The group is safe to
            # signal only now, while the leader is not reaped and its number cannot be given away.
            child.signal_group(signal.SIGTERM)
        returncode = child.reap()
        self._relay.drain(process)
        self._advance(process, Exited(returncode))
        self._finish_if_done()

    def _report_end(self, process: Process, end: Ended) -> None:
        child, outcome = process.child, end.outcome
        if child is not None and outcome.returncode is not None:
            self._tell(process, report.ended(process.spec, child.pid, end))
            self._note(
                "ended",
                process,
                pid=child.pid,
                returncode=outcome.returncode,
                asked=end.asked,
                restart_in_s=end.retry_in_s,
            )
        if end.retry_in_s:
            restarts = process.machine.restarts
            limit = process.machine.restart.max_restarts
            self._tell(process, report.restarts_in(end.retry_in_s, restarts, limit))
        if outcome.failed and not end.asked and end.retry_in_s is None and not self._first_death:
            last_lines = process.last_lines(LAST_LINES)
            self._first_death = report.first_death(process.name, str(outcome), last_lines)
        if process.machine.state is ProcessState.FATAL and process.machine.restarts:
            self._tell(process, report.gave_up(process.machine.restart, process.machine.restarts))
        pid = child.pid if child is not None else -1
        self._forget_child(process)
        self._feed(_event_of(process.process_id, pid, end))

    def _forget_child(self, process: Process) -> None:
        if process.child is not None:
            self._relay.detach(process)
            self._reactor.remove(process.child.pidfd)
            process.child.close()
            process.child = None

    # ---- the end

    def _signalled(self, signum: int) -> None:
        self._stop_signal = self._stop_signal or signum
        name = signal.Signals(signum).name
        how = "ctrl-c (SIGINT)" if signum == signal.SIGINT else name
        if not self._stopping:
            self._say("WARNING", "launch", f"user interrupted with {how}")
            self._feed(SignalReceived(signum=signum))
            self._stop_all(how)
            return
        self._say("WARNING", "launch", f"user interrupted with {how} again, not waiting any longer")
        for process in list(self._processes.values()):
            # One that an OnShutdown handler started has not been asked to stop yet.
            is_new = process.machine.state is ProcessState.RUNNING
            self._advance(process, Stop() if is_new else Hurry())
        if self._remnants is not None:
            self._remnants.hurry()

    def _stop_all(self, reason: str) -> None:
        """Stop everything, the last started first. `reason` is for the log file."""
        if self._stopping:
            return
        self._stopping = True
        self._folder.log("INFO", "launch", f"shutting down: {reason}")
        self._note("stopping", reason=reason)
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()
        for process in reversed(list(self._processes.values())):
            self._advance(process, Stop())
        self._reactor.call_later(WAITING_NOTE_S, self._say_who_lives)
        self._reactor.call_later(0, self._finish_if_done)

    def _say_who_lives(self) -> None:
        alive = [p.name for p in self._processes.values() if p.machine.state.is_alive]
        if alive:
            self._say("INFO", "launch", f"still waiting for {', '.join(alive)}")
            self._reactor.call_later(WAITING_NOTE_S, self._say_who_lives)

    def _finish_if_done(self) -> None:
        """When nothing runs and nothing can start any more, end what processes left behind."""
        if self._timers or self._remnants is not None:
            return
        if any(_is_pending(p.machine.state) for p in self._processes.values()):
            return
        self._stopping = True
        self._remnants = Remnants(
            self._run_id,
            reactor=self._reactor,
            ignore=frozenset() if self._guard is None else frozenset({self._guard.pid}),
            say=lambda level, text: self._say(level, "launch", text),
            on_done=self._reactor.stop,
        )
        self._remnants.check()


def _is_pending(state: ProcessState) -> bool:
    return state.is_alive or state is ProcessState.BACKOFF


def _event_of(process_id: int, pid: int, end: Ended) -> Event:
    outcome = end.outcome
    if outcome.returncode is None:
        number = outcome.spawn_errno or errno.EIO
        return SpawnFailed(process_id=process_id, errno=number, reason=os.strerror(number))
    return ProcessExited(
        process_id=process_id,
        pid=pid,
        returncode=outcome.returncode,
        will_restart=end.retry_in_s is not None,
    )


def _terminal_size(taken: int) -> tuple[int, int]:
    """(columns, rows) that a child's pseudo-terminal gets: ours, less the prefix."""
    try:
        columns, rows = os.get_terminal_size(1)
    except OSError:
        return 80, 24
    return max(20, columns - taken), max(2, rows)
