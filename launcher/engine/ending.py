"""Ending: how a run comes to its end, and with which exit code."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Collection

from launcher.engine.chronicle import Chronicle
from launcher.engine.guard import Guards
from launcher.engine.keeper import Keeper
from launcher.engine.machine import Hurry, ProcessMachine, ProcessState, Stop
from launcher.engine.process import Process
from launcher.engine.reactor import Reactor
from launcher.errors import ExitCode
from launcher.model.events import Event, ShutdownAsked, SignalReceived

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.engine.remnants import Remnants

WAITING_NOTE_S = 1.0  # a stop that takes longer says for whom it waits


class Ending:
    """Stops everything when it has to be, says for whom it waits, and knows when all is over.

    `processes` is what the supervisor knows, in order of start. `tell` hands the interpreter an
    event; `expects_more()` says whether something but the processes may still bring about a
    start; `on_stop()` is called when a stop begins, `on_empty()` when no process is left.
    """

    def __init__(
        self,
        reactor: Reactor,
        chronicle: Chronicle,
        keeper: Keeper,
        *,
        run_id: str,
        guards: Guards,
        processes: Callable[[], Collection[Process]],
        tell: Callable[[Event], None],
        expects_more: Callable[[], bool],
        on_stop: Callable[[], None],
        on_empty: Callable[[], None],
    ) -> None:
        self._reactor = reactor
        self._chronicle = chronicle
        self._keeper = keeper
        self._run_id = run_id
        self._guards = guards
        self._processes = processes
        self._tell = tell
        self._expects_more = expects_more
        self._on_stop = on_stop
        self._on_empty = on_empty
        self._stop_signal: int | None = None
        self._is_output_closed = False
        self._remnants: Remnants | None = None
        self._hurries = 0  # what is left behind has not heard of them
        self.has_begun = False
        self.first_death: str | None = None

    def exit_code(self) -> ExitCode:
        """What the run ends with, as things stand."""
        if self.first_death is None and not self._keeper.has_killed:
            # As programs have it that cannot write what they were to write.
            is_lost = self._chronicle.has_lost_output
            return ExitCode.PROCESS_FAILED if is_lost else ExitCode.OK
        if self._stop_signal is None:
            return ExitCode.PROCESS_FAILED
        is_interrupt = self._stop_signal == signal.SIGINT
        return ExitCode.INTERRUPTED if is_interrupt else ExitCode.TERMINATED

    # ---- reasons

    def signalled(self, signum: int) -> None:
        """A signal asks us to stop; each further one not to wait."""
        is_first = self._stop_signal is None
        self._stop_signal = self._stop_signal or signum
        if signum == signal.SIGHUP and is_first and self.has_begun and self._is_output_closed:
            return  # a closed terminal, whose closed output was noticed first
        name = signal.Signals(signum).name
        how = "ctrl-c (SIGINT)" if signum == signal.SIGINT else name
        if not self.has_begun:
            self._say("WARNING", f"user interrupted with {how}")
            self._tell(SignalReceived(signum=signum))
            self.stop_all(how)
            return
        self._say("WARNING", f"user interrupted with {how} again, not waiting any longer")
        for process in list(self._processes()):
            # One that an OnShutdown handler started has not been asked to stop yet.
            is_new = process.machine.state is ProcessState.RUNNING
            self._keeper.advance(process, Stop() if is_new else Hurry())
        self._hurries += 1
        if self._remnants is not None:
            self._remnants.hurry()

    def output_closed(self) -> None:
        """Nobody reads our output any more. If a terminal was closed, a SIGHUP tells it, too."""
        self._is_output_closed = True
        # Not at once: it may be found out in the middle of reporting on a process.
        self.stop_soon("nobody reads our output any more")

    def stop_soon(self, reason: str) -> None:
        """Stop everything, but not in the middle of what is going on now."""
        self._reactor.call_later(0, lambda: self._stop_and_say(reason))

    def _stop_and_say(self, reason: str) -> None:
        if not self.has_begun:
            self._say("INFO", f"{reason}: shutting down")
            self.shut_down(reason)

    def shut_down(self, reason: str) -> None:
        """Stop everything; handlers of the launch file hear of it, and start nothing more."""
        if not self.has_begun:
            self._tell(ShutdownAsked(reason=reason))
            self.stop_all(reason)

    # ---- the course of the end

    def stop_all(self, reason: str) -> None:
        """Stop everything, the last started first; the interpreter knows already."""
        if self.has_begun:
            return
        self.has_begun = True
        self._chronicle.note("stopping", reason=reason)
        self._on_stop()
        for process in reversed(list(self._processes())):
            self._keeper.advance(process, Stop())
        self._reactor.call_later(WAITING_NOTE_S, self._say_who_lives)
        self._reactor.call_later(0, self.finish_if_done)

    def _say_who_lives(self) -> None:
        alive = [p for p in self._processes() if p.machine.state.is_alive]
        if alive:
            now = self._reactor.now()
            waits = [f"{p.name}{_what_comes_next(p.machine, now)}" for p in alive]
            self._say("INFO", f"still waiting for {', '.join(waits)}")
            self._reactor.call_later(WAITING_NOTE_S, self._say_who_lives)

    def finish_if_done(self) -> None:
        """When nothing runs and nothing can start any more, end what processes left behind."""
        if self._remnants is not None or self._expects_more():
            return
        if any(_is_pending(p.machine, stopping=self.has_begun) for p in self._processes()):
            return
        if not self.has_begun and any(p.held for p in self._processes()):
            return  # a person stopped it, and may start it again
        from launcher.engine.remnants import Remnants, patience_for

        self.has_begun = True
        self._on_empty()
        self._remnants = Remnants(
            self._run_id,
            reactor=self._reactor,
            ignore=self._guards.pids | self._stuck_pids(),
            say=self._say,
            on_done=self._reactor.stop,
            on_kill=self._keeper.note_kill,
            patience=patience_for(p.machine.stop for p in self._processes()),
        )
        self._remnants.check()
        for _ in range(self._hurries):
            self._remnants.hurry()

    def clear_after(self, process: Process, pid: int) -> None:
        """End what a process that was stopped, or starts again, left in its session.

        What one leaves behind that ended by itself may be its purpose (a daemon's parent ends);
        that, and what left the session, stays until the end of the run.
        """
        if self.has_begun or not _has_members(pid):
            return
        from launcher.engine.remnants import Remnants, patience_for

        by_hand = process.held  # as with the process itself: the run has not failed
        Remnants(
            self._run_id,
            reactor=self._reactor,
            ignore=self._guards.pids,
            say=lambda level, text: self._chronicle.say(level, process.name, text),
            on_done=lambda: None,
            on_kill=(lambda: None) if by_hand else self._keeper.note_kill,
            patience=patience_for((process.machine.stop,)),
            session=pid,
        ).check()

    def _stuck_pids(self) -> frozenset[int]:
        """Those that were named already, and that no signal reaches."""
        stuck = (p.child for p in self._processes() if p.machine.is_stuck)
        return frozenset(child.pid for child in stuck if child is not None)

    def _say(self, level: str, text: str) -> None:
        self._chronicle.say(level, "launch", text)


def _what_comes_next(machine: ProcessMachine, now: float) -> str:
    if machine.next_signal is None:
        return ""
    signum, at_s = machine.next_signal
    return f" ({signum.name} in {max(0.0, at_s - now):.1f} s)"


def _is_pending(machine: ProcessMachine, *, stopping: bool) -> bool:
    if machine.is_stuck and stopping:
        return False  # nobody can end it, so nobody waits for its end
    return machine.state.is_alive or machine.state is ProcessState.BACKOFF


def _has_members(group: int) -> bool:
    """Whether somebody is in this process group; a number that is in use is not given away."""
    try:
        os.killpg(group, 0)
    except OSError:
        return False
    return True
