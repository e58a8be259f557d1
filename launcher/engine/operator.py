"""Operator: what a person wants done with the processes of a running run, and what became of it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable

from launcher.engine.chronicle import Chronicle
from launcher.engine.keeper import Keeper
from launcher.engine.machine import POLITE, ProcessState, Start, Stop, signal_name
from launcher.engine.process import Process
from launcher.engine.reactor import Reactor, Timer
from launcher.model.record import Record
from launcher.model.spec import RestartMode

LOOK_S = 0.02  # nobody tells us that a process was paused
LOOK_AGAIN_S = 0.1  # nor that it runs, or is stuck; only while somebody waits
PAUSE_PATIENCE_S = 1.0
SIGNAL_PATIENCE_S = 1.0  # how long an end is waited for after a single signal
STAT_BYTES = 512  # of /proc/PID/stat, more than the state is away from its beginning
NEVER_STARTED = "was stopped before it had started"
WAITS = "waits for its turn to start"
STUCK = "is stuck: not even SIGKILL has ended it"
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


class Outcome(Record):
    """What became of a wish for one process: a sentence, and whether it was fulfilled.

    `stopping`: it was not, because the run as a whole is being stopped.
    """

    process: str
    done: bool
    text: str
    stopping: bool = False


Done = Callable[[Outcome], None]


class Operator:
    """Stops, starts, pauses and signals single processes; `done(outcome)` comes when it happened.

    `is_stopping()` tells that the run is being stopped, when nothing may start any more.
    """

    def __init__(
        self,
        reactor: Reactor,
        keeper: Keeper,
        chronicle: Chronicle,
        *,
        is_stopping: Callable[[], bool],
    ) -> None:
        self._reactor = reactor
        self._keeper = keeper
        self._chronicle = chronicle
        self._is_stopping = is_stopping
        self._waiting: list[Callable[[], bool]] = []
        self._timer: Timer | None = None

    # ---- stop and start

    def stop(self, process: Process, done: Done) -> None:
        """Stop it by its stop policy; it stays, and may be started again."""
        state = process.machine.state
        began_s = self._reactor.now()
        if not state.is_alive and state is not ProcessState.BACKOFF:
            done(_failed(process, f"does not run ({state.value})"))
            return
        self._note("stop", process)
        process.held = True
        life = process.last_end
        self._keeper.advance(process, Stop())
        if state is ProcessState.BACKOFF:
            done(_done(process, "was waiting for its restart, which is off because you asked"))
            return

        def look() -> bool:
            if process.machine.is_stuck:
                done(_failed(process, STUCK))
                return True
            if process.machine.state.is_alive and process.last_end is life:
                return False
            text = self._how_it_stopped(process, began_s)
            if process.last_end is life:
                text = NEVER_STARTED
            if process.machine.state.is_alive:
                done(_done(process, f"{text}, and somebody has started it again"))
                return True
            done(_done(process, f"{text}{_restart_is_off(process)}"))
            return True

        self._wait(look)

    def _how_it_stopped(self, process: Process, began_s: float) -> str:
        elapsed_s = self._reactor.now() - began_s
        last = process.last_end
        if last is not None and last.outcome.returncode is None:
            return str(last.outcome)  # no signal was sent: there was nobody to get it
        end = "" if last is None else str(last.outcome)
        signum = process.machine.stop_signal.name
        how = signum if end == signum else f"{signum}, {end}"
        return f"stopped in {elapsed_s:.2f} s ({how})"

    def start(self, process: Process, done: Done) -> None:
        """Start what has ended; its restarts count afresh."""
        state = process.machine.state
        if self._is_stopping():
            done(_failed(process, "is not started: the run is being stopped", stopping=True))
        elif state is ProcessState.STOPPING:
            self._when_it_has_ended(process, lambda: self.start(process, done), done)
        elif _waits_for_its_turn(process):
            done(_failed(process, WAITS))
        elif state.is_alive:
            pid = "" if process.child is None else f" (pid {process.child.pid})"
            done(_failed(process, f"runs already{pid}"))
        else:
            self._note("start", process)
            self._begin(process, done)

    def _begin(self, process: Process, done: Done, *, before: str = "", after: str = "") -> None:
        """Start it, and say so, between these two, when it runs, or does not."""
        process.held = True  # or the run might end with an attempt that fails
        life = process.last_end
        self._keeper.advance(process, Start())

        def look() -> bool:
            if process.machine.state is ProcessState.STARTING:
                return False  # its turn has not come, or its limits are still being set
            if process.child is not None:
                process.held = False
                done(_done(process, f"{before}started with pid {process.child.pid}{after}"))
            elif process.last_end is life or process.last_end is None:
                done(_failed(process, f"{before}{NEVER_STARTED}"))
            else:
                done(_failed(process, f"{before}{process.last_end.outcome}"))
            return True

        if not look():
            self._wait(look)

    def restart(self, process: Process, done: Done) -> None:
        """Stop it if it runs, then start it."""
        if not process.machine.state.is_alive:
            self.start(process, done)
            return
        if self._is_stopping():
            done(_failed(process, "is not restarted: the run is being stopped", stopping=True))
            return
        if _waits_for_its_turn(process):
            done(_done(process, WAITS))
            return
        self._note("restart", process)
        after = "" if process.child is None else f" instead of {process.child.pid}"
        began_s = self._reactor.now()

        def again() -> None:
            stopped = self._how_it_stopped(process, began_s)
            if self._is_stopping():
                text = f"{stopped}, and not started again: the run is being stopped"
                done(_failed(process, text, stopping=True))
                return
            self._begin(process, done, before=f"{stopped}, ", after=after)

        process.held = True
        self._keeper.advance(process, Stop())
        self._when_it_has_ended(process, again, done)

    def _when_it_has_ended(self, process: Process, then: Callable[[], None], done: Done) -> None:
        def look() -> bool:
            if process.machine.is_stuck:
                done(_failed(process, STUCK))
                return True
            if process.machine.state.is_alive:
                return False
            then()
            return True

        self._wait(look)

    # ---- single signals

    def kill(self, process: Process, signum: int, done: Done) -> None:
        """Send it exactly this signal; if it ends of it, it stays ended."""
        child = process.child
        if child is None:
            done(_failed(process, f"does not run ({process.machine.state.value})"))
            return
        if signum == 0:
            done(_done(process, f"is there (pid {child.pid})"))
            return
        name = signal_name(signum)
        self._note("kill", process, signal=name)
        began_s = self._reactor.now()
        self._keeper.send(process, signum)
        if signum == signal.SIGCONT:
            process.paused = False
        if signum == signal.SIGSTOP:
            process.paused = True
        if signum not in FATAL_BY_DEFAULT:
            done(_done(process, f"got {name}"))
            return

        def look() -> bool:
            elapsed_s = self._reactor.now() - began_s
            if process.child is child:
                if elapsed_s < SIGNAL_PATIENCE_S:
                    return False
                done(_done(process, f"got {name} and still runs"))
                return True
            last = process.last_end
            how = "" if last is None or str(last.outcome) == name else f", {last.outcome}"
            text = f"ended in {elapsed_s:.2f} s ({name}{how}){_restart_is_off(process)}"
            done(_done(process, text))
            return True

        self._wait(look)

    def pause(self, process: Process, done: Done) -> None:
        """Let it stand still, with its whole group, until it is resumed."""
        self._halt_or_go(process, signal.SIGSTOP, done)

    def resume(self, process: Process, done: Done) -> None:
        """Let it go on."""
        self._halt_or_go(process, signal.SIGCONT, done)

    def _halt_or_go(self, process: Process, signum: signal.Signals, done: Done) -> None:
        child = process.child
        pausing = signum == signal.SIGSTOP
        if child is None:
            done(_failed(process, f"does not run ({process.machine.state.value})"))
            return
        if is_halted(child.pid) is pausing and (process.paused or not pausing):
            done(_failed(process, "is paused already" if pausing else "is not paused"))
            return
        self._note("pause" if pausing else "resume", process)
        self._keeper.signal(process, signum)
        process.paused = pausing
        deadline_s = self._reactor.now() + PAUSE_PATIENCE_S
        what = f"paused with {signum.name}" if pausing else f"goes on after {signum.name}"

        def look() -> bool:
            if process.child is not child:
                done(_failed(process, "has ended"))
            elif is_halted(child.pid) is pausing:
                done(_done(process, what))
            elif self._reactor.now() >= deadline_s:
                done(_failed(process, f"got {signum.name}, which has no effect so far"))
            else:
                self._reactor.call_later(LOOK_S, look)
            return True

        look()

    def send(self, process: Process, data: bytes, done: Done) -> None:
        """Hand data to its standard input."""
        if process.child is None:
            done(_failed(process, f"does not run ({process.machine.state.value})"))
            return
        try:
            written = process.child.write_stdin(data)
        except OSError as error:
            done(_failed(process, f"takes nothing on its standard input: {error.strerror}"))
            return
        if written < len(data):
            text = f"took {written} of {len(data)} bytes: it does not read its standard input"
            done(_failed(process, text))
            return
        done(_done(process, f"got {_count(written, 'byte')} on its standard input"))

    # ---- waiting

    def changed(self) -> None:
        """A process has ended: see whether somebody has waited for that."""
        if self._waiting:
            self._reactor.call_later(0, self._look)

    def _wait(self, look: Callable[[], bool]) -> None:
        """Ask `look` soon, after each end, and now and then, until it says yes."""
        self._waiting.append(look)
        self._reactor.call_later(0, self._look)
        if self._timer is None:
            self._timer = self._reactor.call_later(LOOK_AGAIN_S, self._look_again)

    def _look_again(self) -> None:
        self._timer = None
        self._look()
        if self._waiting and self._timer is None:
            self._timer = self._reactor.call_later(LOOK_AGAIN_S, self._look_again)

    def _look(self) -> None:
        waiting, self._waiting = self._waiting, []
        self._waiting = [look for look in waiting if not look()] + self._waiting

    def _note(self, verb: str, process: Process, **details: object) -> None:
        self._chronicle.note("asked", process, verb=verb, **details)


def is_halted(pid: int) -> bool:
    """Whether the process stands still because of SIGSTOP or the like.

    Asked of every process for each `ps`, so without `open()`, which takes three times as long.
    """
    try:
        fd = os.open(f"/proc/{pid}/stat", os.O_RDONLY | os.O_CLOEXEC)
        try:
            text = os.read(fd, STAT_BYTES)
        finally:
            os.close(fd)
    except OSError:
        return False
    return text[text.rindex(b")") + 2 :][:1] in (b"T", b"t")


def _waits_for_its_turn(process: Process) -> bool:
    """Whether starts are paced, and its own has not come yet."""
    return process.machine.state is ProcessState.STARTING and process.child is None


def _restart_is_off(process: Process) -> str:
    if process.spec.restart.mode is RestartMode.NEVER:
        return ""
    return "; restart is off because you asked"


def _done(process: Process, text: str) -> Outcome:
    return Outcome(process=process.name, done=True, text=f"{process.name} {text}")


def _failed(process: Process, text: str, *, stopping: bool = False) -> Outcome:
    return Outcome(
        process=process.name, done=False, text=f"{process.name} {text}", stopping=stopping
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
