"""The starts of processes: the first step, a new process, and the last, its program."""

from __future__ import annotations

import errno

from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.spawn import StartSettings, start, terminal_size_beside
from launcher.run.machine import MachineCommand
from launcher.run.process import Process, adapted, child_environment

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.events import StartProcess
    from launcher.base.model.spec import ProcessSpec
    from launcher.posix.spawn import Child
    from launcher.run.run import Run


class Starts:
    """One for a run: adds processes to it, and requests their first start."""

    def __init__(self, run: Run) -> None:
        self._run = run

    def start(self, effect: StartProcess) -> None:
        """Start a new process, unless a part refuses it."""
        run = self._run
        number = len(run.all_processes)
        spec = adapted(effect.spec, run.options)
        if any(part.refuses(spec) for part in run.parts):
            run.core_driver.not_started(effect.process_id, errno.ECANCELED)
            return
        prefix = run.screen.prefix(spec, number)
        process = Process(effect.process_id, spec, number=number, prefix=prefix)
        run.all_processes[effect.process_id] = process
        for part in run.parts:
            part.adding(process)
        run.driver.advance(process, MachineCommand.START)
        for part in run.parts:
            part.added(process)


class Spawner:
    """One for a run: executes the program of a process, if that is on this machine."""

    def __init__(self, run: Run) -> None:
        self._run = run

    def spawn(self, process: Process) -> Child:
        """Start its program; OSError."""
        self._run.watchdog.ensure()
        spec = process.take_spec()
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
