"""New processes of the launch file."""

from __future__ import annotations

import errno

from launcher.run.machine import MachineCommand
from launcher.run.process import Process, adapted

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.events import StartProcess
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
