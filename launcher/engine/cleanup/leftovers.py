"""Leftovers: what processes leave behind when they end, stopped as politely as they were."""

from __future__ import annotations

import signal
from collections.abc import Iterable

from launcher import proc
from launcher.engine.cleanup import sweep
from launcher.engine.machine import (
    POLITE,
    Action,
    Command,
    Escalate,
    MachineEvent,
    ProcessMachine,
    Signal,
)
from launcher.engine.posix.reactor import Reactor
from launcher.model.spec import RestartPolicy, StopPolicy

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    class LeftoverListener(Protocol):
        """Gets lines for the log, and what becomes of the leftovers."""

        def said(self, level: str, text: str) -> None: ...

        # The polite signals have had no effect.
        def killed(self) -> None: ...

        # There are none (any more), or SIGKILL has had no effect either.
        def gone(self) -> None: ...


CLEAN_LOOKS = 3  # a process that forks all the time may be missed once
FIRST_ROUNDS = 15  # of the chase; every run waits for them at its end, for a millisecond
FORK_LOOP = "a process that forks in a loop"
POLL_S = 0.02  # the end of a process that is not our child has no event
# Orphans often ignore SIGINT: a shell that starts something with `&` sets that.
MOST_S = {signal.SIGINT: 1.0}
MOST_ELSE_S = 5.0


def patience_for(policies: Iterable[StopPolicy]) -> StopPolicy:
    """How to stop what processes with these policies may have left: as the most patient of them.

    It is not known whose it was. No grace period is longer than with the default policy.
    """
    patience = max(policies, key=_polite_s, default=StopPolicy())
    limited = ((signum, min(s, MOST_S.get(signum, MOST_ELSE_S))) for signum, s in patience.steps)
    return StopPolicy(polite=tuple(limited)[:-1])


def _polite_s(policy: StopPolicy) -> float:
    return sum(wait_s for _, wait_s in policy.steps[:-1])


class Leftovers:
    """Grandchildren and daemons that carry the run id, stopped as if they were one process.

    `patience` is how they are stopped. With `session`, only what the process with this pid left
    in its session.
    """

    def __init__(
        self,
        run_id: str,
        *,
        reactor: Reactor,
        listener: LeftoverListener,
        ignore: frozenset[int],
        patience: StopPolicy,
        session: int | None = None,
    ) -> None:
        self._run_id = run_id
        self._session = session
        self._reactor = reactor
        self._ignore = ignore
        self._listener = listener
        self._machine = ProcessMachine(RestartPolicy(), patience)
        self._clean_looks = 0
        self._last_seen = ""

    def check(self) -> None:
        """Look, stop what is there, and look again until nothing is."""
        pids = self._find()
        self._last_seen = _names(pids) or self._last_seen
        is_alive = self._machine.state.is_alive
        self._clean_looks = 0 if pids or self._has_fork_loop() else self._clean_looks + 1
        if self._clean_looks >= (CLEAN_LOOKS if is_alive else 1):
            self._listener.gone()
            return
        if not is_alive:
            who = "processes" if self._session is None else "it"
            self._listener.said(
                "INFO", f"stopping what {who} left behind: {_names(pids) or FORK_LOOP}"
            )
            for event in (Command.START, Command.STARTED, Command.STOP):
                self._advance(event)
        else:
            self._advance(Command.TICK)
        if self._machine.is_stuck:
            self._listener.killed()
            self._listener.said(
                "ERROR", f"could not be killed: {_reasons(pids) or self._last_seen or FORK_LOOP}"
            )
            self._listener.gone()
            return
        if self._machine.is_killing:
            self._signal(signal.SIGKILL)  # something may have forked
        self._reactor.call_later(POLL_S, self.check)

    def _has_fork_loop(self) -> bool:
        """Whether one forks and ends so fast that a look at all processes misses it."""
        if self._session is not None:
            return False
        is_killing = self._machine.is_killing
        return sweep.chase(
            self._run_id,
            signal.SIGKILL if is_killing else 0,
            ignore=self._ignore,
            rounds=sweep.CHASE_ROUNDS if self._machine.state.is_alive else FIRST_ROUNDS,
        )

    def skip_grace(self) -> None:
        """Take the next step now, if there is something to stop."""
        self._advance(Command.SKIP_GRACE)

    def _advance(self, event: MachineEvent) -> None:
        for action in self._machine.handle(event, self._reactor.now()):
            self._do(action)

    def _do(self, action: Action) -> None:
        if isinstance(action, Signal):
            self._signal(action.signum)
        elif isinstance(action, Escalate):
            if action.to == signal.SIGKILL:
                self._listener.killed()
            left = _names(self._find()) or self._last_seen or FORK_LOOP
            self._listener.said(
                "ERROR", f"left behind and still there, now {action.to.name}: {left}"
            )

    def _find(self) -> list[int]:
        return sweep.find(self._run_id, ignore=self._ignore, session=self._session)

    def _signal(self, signum: int) -> None:
        # A suspended process cannot handle any signal but SIGKILL.
        for each in (signum, signal.SIGCONT) if signum in POLITE else (signum,):
            sweep.signal_all(self._run_id, each, ignore=self._ignore, session=self._session)


def _names(pids: list[int]) -> str:
    return ", ".join(f"{proc.command_name(pid) or '?'} [{pid}]" for pid in pids)


def _reasons(pids: list[int]) -> str:
    from launcher.engine.posix.proc import describe_state

    return ", ".join(
        f"{proc.command_name(pid) or '?'} [{pid}, {describe_state(pid)}]" for pid in pids
    )
