"""The members of composed processes in a run: their output, and the end of each."""

from __future__ import annotations

import functools
import signal

from launcher.base.model.events import MemberExited, Outcome
from launcher.base.model.run_events import MemberEnded
from launcher.run.compose.group_output import GroupOutput
from launcher.run.part import Part
from launcher.run.processes.process import Process


class ComposedMembers(Part):
    """Separates the output of the members of composed processes, and reports the end of each."""

    def adding(self, process: Process) -> None:
        specs, screen = process.spec.members, self.run.screen
        if specs:
            names = [
                (spec.name, screen.prefix(spec, process.number + index))
                for index, spec in enumerate(specs)
            ]
            report = functools.partial(self._ended, process)
            process.group = GroupOutput((process.name, process.prefix), names, report)

    def _ended(self, process: Process, index: int, code: int) -> None:
        name = process.spec.members[index].name
        pid = -1 if process.child is None else process.child.pid
        self.run.log.log(*_message(code, name, process))
        self.run.log.note(MemberEnded(name, code), process)
        is_asked = process.machine.is_asked_to_end
        ended = MemberExited(process.process_id, index, pid, code, with_process=is_asked)
        self.run.core_driver.feed(ended)


def _message(code: int, name: str, process: Process) -> tuple[str, str, str]:
    """(level, logger, text)."""
    if code == 0:
        return "INFO", name, f"node has finished cleanly in {process.name}"
    end = Outcome(returncode=code)
    if code == -signal.SIGINT or process.machine.is_asked_to_end:
        return "INFO", name, f"node was stopped in {process.name} ({end})"
    return "ERROR", name, f"node has died in {process.name} ({end})"
