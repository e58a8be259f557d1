"""The state machine of a process on another host: the original there, and the replica here."""

from __future__ import annotations

from collections.abc import Callable

from launcher.base.model.events import Outcome
from launcher.base.model.record import replace
from launcher.base.model.spec import RestartPolicy, StopPolicy
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    Action,
    Exited,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
)

# event, time, seconds from then to the deadline
Report = Callable[[MachineEvent, float, float | None], None]


STARTS = (MachineCommand.START, MachineCommand.USER_START)


class ReportingMachine(ProcessMachine):
    """The original: reports each event before the actions for it are carried out.

    A TICK is reported only if it was due.
    """

    def __init__(self, restart: RestartPolicy, stop: StopPolicy, report: Report) -> None:
        super().__init__(restart, stop)
        self._report = report

    def handle(self, event: MachineEvent, now: float) -> list[Action]:
        is_early = event is MachineCommand.TICK and (self.deadline is None or now < self.deadline)
        actions = super().handle(event, now)
        if not is_early:
            self._report(event, now, None if self.deadline is None else self.deadline - now)
        return actions


class Replica(ProcessMachine):
    """Follows what the host reports.

    A start that was requested and not reported yet shows already: the process is STARTING.
    `refusal` is set if it can never be started there: an errno, and the cause.
    """

    def __init__(self, restart: RestartPolicy, stop: StopPolicy) -> None:
        self._is_handling = False
        self._wanted_starts = 0
        self.refusal: tuple[int, str] | None = None
        super().__init__(restart, stop, chance=lambda: 0.0)  # the host reports the delay

    @property
    def state(self) -> ProcessState:
        if self.is_only_wanted and not self._is_handling:
            return ProcessState.STARTING
        return self._state

    @state.setter
    def state(self, state: ProcessState) -> None:
        self._state = state

    def wants_start(self) -> None:
        """The host will get a command to start it."""
        self._wanted_starts += 1

    def withdraw(self) -> None:
        """The host will not get it after all."""
        self._wanted_starts = 0

    @property
    def is_only_wanted(self) -> bool:
        """Whether it does not run there, and its start was requested."""
        return self._wanted_starts > 0 and not self._state.is_alive

    def follow(self, event: MachineEvent, at_s: float, left_s: float | None) -> list[Action]:
        """As `handle`, for an event that the host has handled; `left_s` as in its report."""
        if event in STARTS:
            self._wanted_starts = max(0, self._wanted_starts - 1)
        if event is MachineCommand.TICK and self.deadline is not None:
            self.deadline = min(self.deadline, at_s)  # it was due there
        actions = self.handle(event, at_s)
        self.deadline = None if left_s is None else at_s + left_s
        return [_delayed(action, left_s or 0.0) for action in actions]

    def adopt(self, state: ProcessState, since_s: float, restarts: int) -> None:
        self._wanted_starts = 0
        super().adopt(state, since_s, restarts)

    def lose(self, outcome: Outcome, at_s: float) -> list[Action]:
        """The host has gone with the process, which nobody will restart."""
        self._wanted_starts = 0
        self.restart = RestartPolicy()
        self._starts_again = False
        if self._state is ProcessState.BACKOFF:
            self._state = ProcessState.RUNNING
        return self.handle(Exited(outcome), at_s)

    def handle(self, event: MachineEvent, now: float) -> list[Action]:
        self._is_handling = True
        try:
            return super().handle(event, now)
        finally:
            self._is_handling = False


def _delayed(action: Action, left_s: float) -> Action:
    """An `ReportExit` with the delay that the host has chosen, which may be random."""
    if isinstance(action, ReportExit) and action.retry_in_s is not None:
        return replace(action, retry_in_s=left_s)
    return action
