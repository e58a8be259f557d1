"""What the launcher does when one of the nodes of a composed process ends."""

from __future__ import annotations

import signal
from collections.abc import Callable

from launcher.base.model.events import Event, MemberExited, Outcome
from launcher.base.model.run_events import MemberEnded
from launcher.output.stdout import StdoutWriter
from launcher.run.compose.output import GroupOutput
from launcher.run.logs.run_log import RunLog
from launcher.run.process import Process


def follow_members(
    process: Process, screen: StdoutWriter, log: RunLog, feed: Callable[[Event], None]
) -> None:
    """From now on tell its members apart; `feed` is called when one has ended."""
    specs = process.spec.members

    def tell(index: int, code: int) -> None:
        name = specs[index].name
        pid = -1 if process.child is None else process.child.pid
        log.log(*_message(code, name, process))
        log.note(MemberEnded(name, code), process)
        is_asked = process.machine.is_asked_to_end
        feed(MemberExited(process.process_id, index, pid, code, with_process=is_asked))

    names = [
        (spec.name, screen.prefix(spec, process.number + index)) for index, spec in enumerate(specs)
    ]
    process.group = GroupOutput((process.name, process.prefix), names, tell)


def _message(code: int, name: str, process: Process) -> tuple[str, str, str]:
    """(level, logger, text)."""
    if code == 0:
        return "INFO", name, f"node has finished cleanly in {process.name}"
    end = Outcome(returncode=code)
    if code == -signal.SIGINT or process.machine.is_asked_to_end:
        return "INFO", name, f"node was stopped in {process.name} ({end})"
    return "ERROR", name, f"node has died in {process.name} ({end})"
