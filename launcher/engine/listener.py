"""RunListener: what the parts of a run report to, and ask. For type checkers alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from launcher.engine.machine import Ended
    from launcher.engine.monitor.budgets import Verdict
    from launcher.engine.posix.spawn import Child
    from launcher.engine.process import Process
    from launcher.model.events import StartProcess


class RunListener(Protocol):
    """The supervisor of a run, or a test's own."""

    # The core of the run starts a new process, or stops everything.
    def start(self, effect: StartProcess) -> None: ...
    def shut_down(self, reason: str) -> None: ...

    # Start the program of a process; OSError.
    def spawn(self, process: Process) -> Child: ...

    # It runs. A life of it is over, and reported; `pid` is -1 if it could not be started.
    def started(self, process: Process, pid: int) -> None: ...
    def ended(self, process: Process, pid: int, end: Ended) -> None: ...

    # It was stopped while it was queued to start.
    def cancelled(self, process: Process) -> None: ...

    # A process is about to get SIGKILL.
    def before_kill(self) -> None: ...

    # It has ended, and nothing of its session is to outlive it.
    def may_have_left(self, process: Process, session: int) -> None: ...

    # Whether its output is wanted, asked for each read; and what was read.
    def watches(self, process: Process) -> bool: ...
    def output(self, process: Process, stream: str, data: bytes) -> None: ...

    # It has been over a limit for too long.
    def over_budget(self, process: Process, verdict: Verdict) -> None: ...

    # Something has ended or become due, and everything about it has been done.
    def idle(self) -> None: ...
