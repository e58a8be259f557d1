"""The interface through which the parts of a run report to the supervisor, for type checkers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from launcher.base.model.events import LoadComponent, StartProcess
    from launcher.posix.spawn import Child
    from launcher.run.machine import Ended
    from launcher.run.monitor.budgets import Verdict
    from launcher.run.process import Process


class RunListener(Protocol):
    """The supervisor of a run, or a fake of a test."""

    # The launch file starts a new process, or shuts the run down.
    def start(self, effect: StartProcess) -> None: ...
    def shut_down(self, reason: str, *, is_interrupted: bool) -> None: ...

    # A container has loaded the node that it was asked for; the node's full name.
    def loaded(self, effect: LoadComponent, full_name: str) -> None: ...

    # Start the program of a process; OSError.
    def spawn(self, process: Process) -> Child: ...

    # What must hold until it counts as ready: facts of `ready_when`, as texts.
    def awaited_facts(self, process: Process) -> list[str]: ...

    # It is running. It has exited, which is logged; `pid` is -1 if it could not be started.
    def started(self, process: Process, pid: int) -> None: ...
    def ended(self, process: Process, pid: int, end: Ended) -> None: ...

    # It was stopped while it was queued to start.
    def cancelled(self, process: Process) -> None: ...

    # A process is about to get SIGKILL.
    def before_kill(self) -> None: ...

    # It has exited, and leftovers in its session are to be stopped.
    def may_have_left(self, process: Process, session: int) -> None: ...

    # Whether the launch file handles its output, called for each read; and what was read.
    def watches(self, process: Process) -> bool: ...
    def output(self, process: Process, stream: str, data: bytes) -> None: ...

    # End the run, unless it is ending already.
    def stop(self, reason: str) -> None: ...

    # A host was lost or could not be reached, which is a failure of the run.
    def host_failed(self, cause: str) -> None: ...

    # It has exceeded a limit for too long.
    def over_budget(self, process: Process, verdict: Verdict) -> None: ...

    # An event has been handled completely: the run may be over.
    def idle(self) -> None: ...
