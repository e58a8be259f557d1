"""Stops what processes leave behind when they exit: SIGINT, SIGTERM, SIGKILL, as for a process."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Mapping

from launcher.base.model.spec import RestartPolicy, StopPolicy
from launcher.posix import proc
from launcher.posix.cleanup import sweep
from launcher.posix.reactor import Reactor
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    POLITE,
    Action,
    Escalate,
    MachineCommand,
    MachineEvent,
    Signal,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    class LeftoverListener(Protocol):
        """Gets lines for the log, and the outcome."""

        def report(self, level: str, text: str) -> None: ...

        # SIGKILL follows, since the signals before had no effect.
        def killing(self) -> None: ...

        # No leftovers exist, or SIGKILL had no effect either.
        def finished(self) -> None: ...


CLEAN_SCANS = 3  # a process that forks in a loop may be missed once
FIRST_ROUNDS = 15  # of `signal_newest`; every run waits for them at its end, for a millisecond
FORK_LOOP = "a process that forks in a loop"
IN_EXEC_TIMEOUT_S = 2.0  # for a process in exec; it may belong to somebody else
POLL_S = 0.02  # the exit of a process that is not our child has no event
# Orphans often ignore SIGINT: a shell sets that for what it starts with `&`.
MAX_GRACE_S = {signal.SIGINT: 1.0}
MAX_GRACE_ELSE_S = 5.0


def stop_policy_for(policies: Iterable[StopPolicy]) -> StopPolicy:
    """The stop policy for leftovers of processes with these policies: the longest of them.

    It is not known which process a leftover comes from. Grace periods are limited to those of the
    default policy.
    """
    longest = max(policies, key=lambda policy: policy.grace_s, default=StopPolicy())
    limited = (
        (signum, min(grace_s, MAX_GRACE_S.get(signum, MAX_GRACE_ELSE_S)))
        for signum, grace_s in longest.steps[:-1]
    )
    return StopPolicy(polite=tuple(limited))


class Leftovers:
    """Grandchildren and daemons of a run, stopped by `policy` like one process.

    They have the run id, or are among those that `kin()` returns, pid -> start. With `session`,
    only those in the session of the process with this pid.
    """

    def __init__(
        self,
        run_id: str,
        *,
        reactor: Reactor,
        listener: LeftoverListener,
        ignore: frozenset[int],
        policy: StopPolicy,
        session: int | None = None,
        kin: Callable[[], Mapping[int, int]] = dict,
    ) -> None:
        self._run_id = run_id
        self._session = session
        self._kin = kin
        self._reactor = reactor
        self._ignore = ignore
        self._listener = listener
        self._machine = ProcessMachine(RestartPolicy(), policy)
        self._clean_scans = 0
        self._last_seen = ""
        self._in_exec_until = reactor.now() + IN_EXEC_TIMEOUT_S

    def check(self) -> None:
        """Find leftovers, stop them, and repeat until there are none."""
        pids, in_exec = self._find()
        self._last_seen = _names(pids) or self._last_seen
        is_alive = self._machine.state.is_alive
        has_leftovers = bool(pids) or self._has_fork_loop()
        may_have_more = bool(in_exec) and self._reactor.now() < self._in_exec_until
        self._clean_scans = 0 if has_leftovers or may_have_more else self._clean_scans + 1
        if self._clean_scans >= (CLEAN_SCANS if is_alive else 1):
            self._listener.finished()
            return
        if not is_alive and has_leftovers:
            self._listener.report(
                "INFO", f"stopping leftover processes: {_names(pids) or FORK_LOOP}"
            )
            for event in (MachineCommand.START, MachineCommand.STARTED, MachineCommand.STOP):
                self._advance(event)
        elif is_alive:
            self._advance(MachineCommand.TICK)
        if self._machine.is_stuck:
            self._listener.killing()
            left = _reasons(pids) or self._last_seen or FORK_LOOP
            self._listener.report("ERROR", f"could not be killed: {left}")
            self._listener.finished()
            return
        if self._machine.is_killing:
            self._signal(signal.SIGKILL)  # something may have forked
        self._reactor.call_later(POLL_S, self.check)

    def _has_fork_loop(self) -> bool:
        """Whether a process forks and exits so fast that a scan of all processes misses it."""
        if self._session is not None:
            return False
        is_killing = self._machine.is_killing
        return sweep.signal_newest(
            self._run_id,
            signal.SIGKILL if is_killing else 0,
            ignore=self._ignore,
            rounds=sweep.NEWEST_ROUNDS if self._machine.state.is_alive else FIRST_ROUNDS,
        )

    def skip_grace(self) -> None:
        """Send the next signal now, if there are leftovers."""
        self._advance(MachineCommand.SKIP_GRACE)

    def _advance(self, event: MachineEvent) -> None:
        for action in self._machine.handle(event, self._reactor.now()):
            self._do(action)

    def _do(self, action: Action) -> None:
        if isinstance(action, Signal):
            self._signal(action.signum)
        elif isinstance(action, Escalate):
            if action.to == signal.SIGKILL:
                self._listener.killing()
            left = _names(self._find()[0]) or self._last_seen or FORK_LOOP
            text = f"leftover processes still running, sending {action.to.name}: {left}"
            self._listener.report("ERROR", text)

    def _find(self) -> tuple[list[int], list[int]]:
        return sweep.find(self._run_id, ignore=self._ignore, session=self._session, kin=self._kin())

    def _signal(self, signum: int) -> None:
        # A suspended process cannot handle any signal but SIGKILL.
        for each in (signum, signal.SIGCONT) if signum in POLITE else (signum,):
            sweep.signal_all(
                self._run_id, each, ignore=self._ignore, session=self._session, kin=self._kin()
            )


def _names(pids: list[int]) -> str:
    return ", ".join(f"{proc.command_name(pid) or '?'} [{pid}]" for pid in pids)


def _reasons(pids: list[int]) -> str:
    return ", ".join(
        f"{proc.command_name(pid) or '?'} [{pid}, {proc.describe_state(pid)}]" for pid in pids
    )
