"""Executes the program of a process: the last step of each start on this machine."""

from __future__ import annotations

from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.spawn import StartSettings, start, terminal_size_beside
from launcher.run.process import child_environment

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.spec import ProcessSpec
    from launcher.posix.spawn import Child
    from launcher.run.process import Process
    from launcher.run.run import Run


class Spawner:
    """One for a run."""

    def __init__(self, run: Run) -> None:
        self._run = run

    def spawn(self, process: Process) -> Child:
        """Start its program; OSError."""
        self._run.watchdog.ensure()
        spec = process.take_debugger()
        return start(spec, self.settings_of(process, spec))

    def settings_of(self, process: Process, spec: ProcessSpec) -> StartSettings:
        """How a process is started that runs `spec`."""
        env = child_environment(
            spec,
            run_id_entry=(RUN_ID_VARIABLE, self._run.id),
            log_dir=self._run.log_dir,
            colour=self._run.screen.colour,
        )
        size = terminal_size_beside(len(process.name) + 3) if spec.emulate_tty else None
        return StartSettings(env, merge=self.merges(process), terminal_size=size)

    def merges(self, process: Process) -> bool:
        """Whether its two streams are one."""
        return process.streams_can_merge and not self._run.core_driver.watches(process)
