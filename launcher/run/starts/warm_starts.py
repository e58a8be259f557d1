"""Starts Python programs warm, by a package that is imported for the first that may have one."""

from __future__ import annotations

import time

from launcher.run.part import StartStage
from launcher.run.processes.machine_events import ProcessState

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.processes.process import Process
    from launcher.run.warm.spawner import WarmSpawner


class WarmStarts(StartStage):
    """Starts a process warm, now or when that is prepared, or passes it on to be started cold."""

    _spawner: WarmSpawner | None = None

    def admit(self, process: Process) -> None:
        process.begun_wall_s = time.time()
        spawner = self._spawner_for(process)
        if spawner is None or not spawner.admit(process):
            self.pass_on(process)

    def _spawner_for(self, process: Process) -> WarmSpawner | None:
        """None if it cannot be started warm in any case."""
        if not self._is_wanted(process):
            return None
        if self._spawner is None and not process.next_debugger:
            self._spawner = self._new_spawner(process)
        return self._spawner

    def _new_spawner(self, process: Process) -> WarmSpawner | None:
        """Imported for the first process that may be warm."""
        from launcher.packages.python_program import program_of

        program = program_of(process.spec.argv, process.spec.env, process.spec.cwd)
        if isinstance(program, str):
            process.start_kind = f"cold, because {program}"
            return None
        from launcher.run.warm.spawner import WarmSpawner

        run = self.run
        run.watchdog.ensure()  # which adopts orphans from now on
        spawner = WarmSpawner(
            run.reactor,
            run.driver,
            settings_of=run.spawner.settings_of,
            warn=run.log.warn,
            is_forced=bool(run.options.warm),
            is_interactive=run.options.watch or (run.options.console and run.screen.is_tty),
            held=self._held_back,
        )
        if run.is_begun:
            spawner.settle()
        return spawner

    def _is_wanted(self, process: Process) -> bool:
        return process.host is None and bool(self.run.options.warm or process.spec.ros)

    def _held_back(self) -> list[Process]:
        """Those whose start was asked for, and that wait for others or for their turn."""
        return [
            one
            for one in self.run.all_processes.values()
            if self._is_wanted(one)
            and one.machine.state is ProcessState.STARTING
            and one.child is None
        ]

    def settled(self) -> None:
        if self._spawner is not None:
            self._spawner.settle()

    def expect(self, process: Process) -> None:
        if self._spawner is not None and self._is_wanted(process):
            self._spawner.expect(process)

    def withdraw(self, process: Process) -> bool:
        return self._spawner is not None and self._spawner.withdraw(process)

    def is_starting(self, process: Process) -> bool:
        return self._spawner is not None and self._spawner.is_starting(process)

    def awaits_preparation(self, process: Process) -> bool:
        return self._spawner is not None and self._spawner.awaits_preparation(process)

    def end_helpers(self) -> None:
        if self._spawner is not None:
            self._spawner.close()
