"""What the driver of processes needs of a run, for type checkers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from launcher.posix.reactor import Reactor
    from launcher.posix.spawn import Child
    from launcher.run.logs.run_log import RunLog
    from launcher.run.output.output_reader import OutputReader
    from launcher.run.part import StartStage
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.processes.process import Process

    class Spawning(Protocol):
        # Start the program of a process; OSError.
        def spawn(self, process: Process) -> Child: ...


class DrivenRun(Protocol):
    """A run, or a fake of a test; `Run` says what the methods mean."""

    @property
    def reactor(self) -> Reactor: ...
    @property
    def reader(self) -> OutputReader: ...
    @property
    def log(self) -> RunLog: ...
    @property
    def spawner(self) -> Spawning: ...

    # Through which starts go, in this order.
    @property
    def stages(self) -> Sequence[StartStage]: ...

    def started(self, process: Process, pid: int) -> None: ...
    def ended(self, process: Process, pid: int, end: ReportExit) -> None: ...
    def cancelled(self, process: Process) -> None: ...
    def before_kill(self) -> None: ...
    def may_have_left(self, process: Process, session: int) -> None: ...
    def idle(self) -> None: ...
