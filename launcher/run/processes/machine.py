"""The state machine of one process, without I/O.

Time is an argument (seconds on the monotonic clock). `handle()` returns the actions that the driver
has to carry out; `deadline` is when the driver has to send a `TICK`.

    STOPPED --start--> STARTING --started--> RUNNING --exit--> EXITED | BACKOFF | FATAL
       ^                  |  spawn failed: as an exit            |
       |                  v                                      v
       +---- exit --- STOPPING <--stop-- RUNNING     BACKOFF --tick--> STARTING
"""

from __future__ import annotations

import errno
import os
import signal
from collections.abc import Callable

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy, StopPolicy
from launcher.run.processes.machine_events import (
    POLITE,
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

# Errors that may be over soon: too many processes or files, too little memory.
TRANSIENT = frozenset({errno.EAGAIN, errno.EMFILE, errno.ENFILE, errno.ENOMEM})
# A process that is being stopped may end by these whoever sends them, as for systemd: they are
# requests to end, or mean that a reader has gone, which may have been stopped before.
ORDERLY = frozenset({signal.SIGHUP, signal.SIGINT, signal.SIGTERM, signal.SIGPIPE})
# Or by these, with which it limits the time of its clean-up: see `setitimer`.
OWN_TIMERS = frozenset({signal.SIGALRM, signal.SIGVTALRM, signal.SIGPROF})
SPAWN_RETRY_S = 1.0  # at least, after such an error


class ProcessMachine:
    """Feed it events, and carry out the actions that it returns.

    `is_held`: a user has stopped it or is starting it, so that the run does not end without it,
    and a SIGKILL is not a failure. `is_suspended`: a user has suspended it. `had_to_be_killed`: it
    exited only by SIGKILL, or not even by that, which is a failure of the run. `running_since`: the
    begin of its last life; None before the first, and while the next start is not complete.
    """

    def __init__(
        self,
        restart: RestartPolicy,
        stop: StopPolicy,
        *,
        chance: Callable[[], float] = lambda: os.urandom(1)[0] / 256,
    ) -> None:
        self.restart = restart
        self.stop = stop
        self.state = ProcessState.STOPPED
        self.deadline: float | None = None
        self.is_held = False
        self.is_suspended = False
        self.had_to_be_killed = False
        self.restarts = 0  # since the last Start or UserStart
        self._chance = chance
        self._step = 0
        self._next_stop: StopPolicy | None = None
        self._sent: dict[int, float] = {}  # by users
        self._signals: frozenset[int] = frozenset()  # that were sent to it in this life
        self._quick_ends = 0
        self._starts_again = False
        self._is_stuck = False
        self.running_since: float | None = None
        self._recent: list[float] = []  # an empty deque takes 600 bytes

    def apply(self, restart: RestartPolicy, stop: StopPolicy) -> None:
        """Change its policies; a stop that is under way goes on as it began."""
        if restart != self.restart:
            self.restart = restart
            self._forget_old_restarts()
        self._next_stop = stop
        self._take_stop()

    def _take_stop(self) -> None:
        if self._next_stop is not None and self.state is not ProcessState.STOPPING:
            self.stop, self._next_stop = self._next_stop, None

    @property
    def stop_signal(self) -> signal.Signals:
        """The last signal that its last stop has sent."""
        return self.stop.steps[self._step][0]

    @property
    def next_signal(self) -> tuple[signal.Signals, float] | None:
        """The next signal of a stop, and its time; None if there is none."""
        is_last = self._step + 1 == len(self.stop.steps)
        if self.state is not ProcessState.STOPPING or is_last or self.deadline is None:
            return None
        return self.stop.steps[self._step + 1][0], self.deadline

    @property
    def is_pending(self) -> bool:
        """Whether it is running, or will be restarted."""
        return self.state.is_alive or self.state is ProcessState.BACKOFF

    @property
    def may_restart(self) -> bool:
        """Whether a restart may follow if it exits now."""
        is_running = self.state is ProcessState.RUNNING
        return is_running and self.restart.mode is not RestartMode.NEVER

    @property
    def has_used_up_restarts(self) -> bool:
        """Whether it has ended, and would be restarted again if its policy had no limit."""
        has_failed = self.state is ProcessState.FATAL
        has_ended = has_failed or self.state is ProcessState.EXITED
        wanted = self.restart.wants_restart(failed=has_failed)
        return has_ended and wanted and self.restarts > 0

    @property
    def is_killing(self) -> bool:
        """Whether SIGKILL has been sent."""
        return self.state is ProcessState.STOPPING and self.stop_signal == signal.SIGKILL

    @property
    def is_asked_to_end(self) -> bool:
        """Whether it is being stopped, or a user has sent a signal that asks for its exit."""
        return self.state is ProcessState.STOPPING or not POLITE.isdisjoint(self._sent)

    @property
    def is_stuck(self) -> bool:
        """Whether it still exists after SIGKILL."""
        return self._is_stuck and self.state is ProcessState.STOPPING

    def handle(self, event: MachineEvent, now: float) -> list[Action]:
        """The actions for `event`, in order; none if it does not apply in this state."""
        match event, self.state:
            case MachineCommand.START | MachineCommand.USER_START, state if not state.is_alive:
                # Held until it runs, or the run might end with an attempt that fails.
                self.is_held = self.is_held or event is MachineCommand.USER_START
                return self._start()
            case MachineCommand.STARTED, ProcessState.STARTING:
                # STARTING -> RUNNING
                self.running_since = now
                self.is_held = False
                self._enter(ProcessState.RUNNING)
            case MachineCommand.STARTED, ProcessState.STOPPING:
                self.running_since = now
                return self._signal(0, now)
            case SpawnError(errno=number, what=what), ProcessState.STARTING | ProcessState.STOPPING:
                return self._end(Outcome(spawn_errno=number, spawn_what=what), now)
            case MachineCommand.START_CANCELLED, ProcessState.STARTING | ProcessState.STOPPING:
                # STARTING, STOPPING -> STOPPED: there is nothing to wait for
                self._enter(ProcessState.STOPPED)
            case Exited(outcome=outcome), state if state.is_alive:
                return self._end(outcome, now)
            case MachineCommand.USER_STOP, _ if self.is_pending:
                self.is_held = True
                return self._stop(now)
            case MachineCommand.INTERRUPTED, ProcessState.RUNNING if not self.is_suspended:
                return [one for one in self._stop(now) if one != Signal(signal.SIGINT)]
            case MachineCommand.STOP | MachineCommand.INTERRUPTED, _:
                return self._stop(now)
            case MachineCommand.RESTART, ProcessState.RUNNING:  # a stop that is under way stays one
                actions = self._stop(now)
                self._starts_again = True
                return actions
            case MachineCommand.SKIP_GRACE, ProcessState.RUNNING:
                return self._stop(now)
            case MachineCommand.SKIP_GRACE, ProcessState.STOPPING:
                return self._escalate(now)
            case SignalSent(), state if state.is_alive:
                return self._sent_to(event, now)
            case MachineCommand.SUSPEND, state if state.is_alive:
                self.is_suspended = True
                return [Signal(signal.SIGSTOP)]
            case MachineCommand.RESUME, state if state.is_alive:
                self.is_suspended = False
                return [Signal(signal.SIGCONT)]
            case MachineCommand.TICK, _ if self.deadline is not None and now >= self.deadline:
                return self._due(now)
        return []

    def adopt(self, state: ProcessState, since_s: float, restarts: int) -> None:
        """Begin with a process that exists, or has existed, without an event."""
        self.restarts, self.running_since = restarts, since_s
        self._enter(state)

    def _enter(self, state: ProcessState, deadline: float | None = None) -> None:
        self.state = state
        if state is ProcessState.STARTING:
            self._signals = frozenset()
            self._sent.clear()
            self.running_since = None
        self._is_stuck = False
        self.deadline = deadline
        self._take_stop()

    def _start(self) -> list[Action]:
        # STOPPED, EXITED, FATAL, BACKOFF -> STARTING: a requested start resets the counters
        self.restarts = 0
        self._recent.clear()
        self._quick_ends = 0
        self._enter(ProcessState.STARTING)
        return [MachineAction.SPAWN]

    def _stop(self, now: float) -> list[Action]:
        self._starts_again = False
        if self.state is ProcessState.RUNNING:
            return self._signal(0, now)
        if self.state is ProcessState.STARTING:
            # STARTING -> STOPPING: the signal follows when there is a process
            self._enter(ProcessState.STOPPING)
        elif self.state is ProcessState.BACKOFF:
            # BACKOFF -> STOPPED
            self._enter(ProcessState.STOPPED)
        return []

    def _sent_to(self, sent: SignalSent, now: float) -> list[Action]:
        is_waking = self.is_suspended and sent.signum in POLITE
        self._signals |= {sent.signum}
        if sent.by_user and self.state is not ProcessState.STOPPING:
            self._sent[sent.signum] = now
        if is_waking or (sent.by_user and sent.signum == signal.SIGCONT):
            self.is_suspended = False
        elif sent.by_user and sent.signum == signal.SIGSTOP:
            self.is_suspended = True
        return [MachineAction.WAKE] if is_waking else []

    def _due(self, now: float) -> list[Action]:
        if self.state is ProcessState.BACKOFF:
            # BACKOFF -> STARTING
            self.restarts += 1
            self._recent.append(now)
            self._forget_old_restarts()
            self._enter(ProcessState.STARTING)
            return [MachineAction.SPAWN]
        if self._step + 1 == len(self.stop.steps):
            self._is_stuck = self.had_to_be_killed = True
            self.deadline = None
            return [ReportStuck(self.stop.steps[-1][1])]
        return self._escalate(now)

    def _forget_old_restarts(self) -> None:
        """Keep the times of as many as the policy counts."""
        most = self.restart.max_restarts or 0
        del self._recent[: max(0, len(self._recent) - most)]

    def _signal(self, step: int, now: float) -> list[Action]:
        """Send the signal of this step of the stop: RUNNING, STOPPING -> STOPPING."""
        self._step = step
        signum, wait_s = self.stop.steps[step]
        self._signals |= {signum}
        self.is_suspended = self.is_suspended and signum not in POLITE
        self._enter(ProcessState.STOPPING, now + wait_s)
        return [Signal(signum)]

    def _escalate(self, now: float) -> list[Action]:
        if self._step + 1 == len(self.stop.steps) or self.deadline is None:
            return []
        after, wait_s = self.stop.steps[self._step]
        waited_s = wait_s - max(0.0, self.deadline - now)
        to = self.stop.steps[self._step + 1][0]
        self.had_to_be_killed |= to == signal.SIGKILL and not self.is_held
        return [Escalate(after, waited_s, to), *self._signal(self._step + 1, now)]

    def _end(self, outcome: Outcome, now: float) -> list[Action]:
        self.is_suspended = False
        if self.state is ProcessState.STOPPING:
            return [self._end_of_stop(outcome, now)]
        if self._ends_of_what_was_sent(outcome, now):
            # RUNNING -> STOPPED
            self.is_held = True
            self._enter(ProcessState.STOPPED)
            return [ReportExit(outcome, asked=True, retry_in_s=None, sent=True)]
        if self._retries(outcome, now):
            # RUNNING, STARTING -> BACKOFF, even without a delay, so that a stop can come in between
            delay_s = self._delay_s(outcome, now)
            self._enter(ProcessState.BACKOFF, now + delay_s)
            return [ReportExit(outcome, asked=False, retry_in_s=delay_s)]
        gave_up = outcome.failed and self.restart.mode is not RestartMode.NEVER
        # RUNNING, STARTING -> FATAL or EXITED
        is_fatal = gave_up or outcome.spawn_errno is not None
        self._enter(ProcessState.FATAL if is_fatal else ProcessState.EXITED)
        return [ReportExit(outcome, asked=False, retry_in_s=None)]

    def _end_of_stop(self, outcome: Outcome, now: float) -> ReportExit:
        crashed = self._has_crashed(outcome)
        if self._starts_again:
            # STOPPING -> BACKOFF: a requested restart has no delay
            self._starts_again = False
            self._enter(ProcessState.BACKOFF, now)
            return ReportExit(outcome, asked=not crashed, retry_in_s=0.0, crashed=crashed)
        # STOPPING -> STOPPED
        self._enter(ProcessState.STOPPED)
        return ReportExit(outcome, asked=not crashed, retry_in_s=None, crashed=crashed)

    def _has_crashed(self, outcome: Outcome) -> bool:
        """Whether a process that is being stopped was ended by a signal that nobody had sent."""
        code = outcome.returncode
        if code is None or code >= 0 or outcome.lost_with:
            return False
        return -code not in self._signals | ORDERLY | OWN_TIMERS

    def _ends_of_what_was_sent(self, outcome: Outcome, now: float) -> bool:
        if not self._sent or outcome.returncode is None:
            return False
        if any(outcome.returncode in (-signum, 128 + signum) for signum in self._sent):
            return True
        if outcome.returncode < 0:
            return False  # of another signal: it crashed
        # A process that cleans up after a polite signal may exit with any code.
        grace_s = self.stop.grace_s
        return any(
            signum in POLITE and now - when <= grace_s for signum, when in self._sent.items()
        )

    def _retries(self, outcome: Outcome, now: float) -> bool:
        if outcome.spawn_errno is not None and outcome.spawn_errno not in TRANSIENT:
            return False  # a missing program will still be missing in a second
        wanted = self.restart.wants_restart(failed=outcome.failed)
        return wanted and self.restart.allows(self.restarts, self._recent, now)

    def _delay_s(self, outcome: Outcome, now: float) -> float:
        run_s = 0.0 if self.running_since is None else now - self.running_since
        if outcome.spawn_errno is None and run_s >= self.restart.quiet_s:
            self._quick_ends = 0
        chance = self._chance() if self.restart.jitter else 0.0
        delay_s = self.restart.delay_after(self._quick_ends, chance)
        self._quick_ends += 1
        return max(delay_s, SPAWN_RETRY_S) if outcome.spawn_errno is not None else delay_s
