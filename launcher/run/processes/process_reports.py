"""What is logged about a process: a line on the screen, and an entry of the event log.

Times `at_s` are on the monotonic clock, for what happened on another host; None: just now.
"""

from __future__ import annotations

import os

from launcher.base.model import run_events
from launcher.base.model.events import SIGNALLED, refusal
from launcher.base.model.run_events import known
from launcher.run.logs import messages
from launcher.run.logs.run_log import RunLog
from launcher.run.processes.machine_events import Escalate, ProcessState, ReportExit
from launcher.run.processes.process import Process


class ProcessReports:
    """Imported for the first report: the way to the first child is shorter without."""

    def __init__(self, log: RunLog) -> None:
        self._log = log

    def started(self, process: Process, pid: int, at_s: float | None = None) -> None:
        self._log.report(process, messages.started(pid, process.host_name))
        started = run_events.Started(pid, process.machine.restarts, process.awaited_facts)
        self._log.note(started, process, at_s)

    def adopted(
        self, process: Process, pid: int, state: ProcessState, age_s: float, restarts: int
    ) -> None:
        line = messages.adopted(state, pid, process.host_name, age_s, restarts)
        self._log.report(process, line)
        self._log.note(run_events.Adopted(known(pid), state.value, restarts), process)

    def refused(self, process: Process, number: int, what: str, at_s: float | None = None) -> None:
        self._log.report(process, messages.not_started(process, number, what))
        self._log.note(run_events.NotStarted(refusal(number, what)), process, at_s)

    def cancelled(self, process: Process, at_s: float | None = None) -> None:
        self._log.report(process, messages.start_cancelled())
        self._log.note(run_events.Withdrawn(), process, at_s)

    def signalled(self, process: Process, pid: int, signum: int, at_s: float | None = None) -> None:
        self._log.report(process, messages.signalled(process.name, signum))
        self._log.note(run_events.Signalled(known(pid), int(signum)), process, at_s)

    def escalated(self, process: Process, step: Escalate) -> None:
        by_user = process.machine.is_held
        self._log.report(process, messages.escalated(process.name, step, by_user=by_user))

    def stuck(
        self, process: Process, pid: int, waited_s: float, how: str, at_s: float | None = None
    ) -> None:
        self._log.report(process, messages.stuck(process.name, pid, waited_s, how))
        sleeps = how if process.host is None else None
        self._log.note(run_events.Stuck(known(pid), sleeps), process, at_s)

    def unread_input(self, process: Process, error: OSError) -> None:
        text = f"cannot write to its standard input: {os.strerror(error.errno or 0)}"
        self._log.report(process, messages.Line("WARNING", text))

    def ended(self, process: Process, pid: int, end: ReportExit, at_s: float | None = None) -> None:
        """Its exit, and the core file; nothing if it was not started."""
        returncode = end.outcome.returncode
        if returncode is None:
            return
        by_user = process.machine.is_held
        self._log.report(process, messages.ended(process, pid, end, by_user=by_user))
        ended = run_events.Ended(known(pid), returncode, end.asked, end.retry_in_s)
        self._log.note(ended, process, at_s)
        self._core(process, pid, end)

    def _core(self, process: Process, pid: int, end: ReportExit) -> None:
        """Name the core file after a death by a signal; how to get one is said once."""
        code = end.outcome.returncode or 0
        if end.asked or process.host is not None or 0 <= code <= SIGNALLED:
            return
        from launcher.run.logs import core_file

        note = core_file.note_of(process, pid, end.outcome)
        has_core = end.outcome.core_dumped or code > 0
        if note and (has_core or process.history.core_note != note):
            self._log.report(process, messages.Line("ERROR" if has_core else "INFO", note))
        process.history.core_note = note

    def hung(self, process: Process, now: float) -> None:
        """It has ended while its node did not answer: keep its stack for the summary."""
        silence, process.silence = process.silence, None
        assert silence is not None
        text = f"had not responded for {silence.elapsed_s(now):.0f} s before it ended"
        process.history.hang = (f"{process.name} {text}; its stack:", *silence.stack)
        stack = "".join(f"\n    {line}" for line in silence.stack)
        self._log.log("WARNING", process.name, f"{text}; its stack:{stack}", sink="log")

    def restart(self, process: Process, end: ReportExit) -> None:
        """What follows the exit."""
        machine = process.machine
        if end.retry_in_s:
            most = machine.restart.max_restarts
            line = messages.restarts_in(end.retry_in_s, machine.restarts, most)
            self._log.report(process, line)
        if machine.has_used_up_restarts:
            self._log.report(process, messages.restarts_used_up(machine))

    def no_longer_read(self, name: str) -> None:
        self._log.log("WARNING", "launch", messages.no_longer_read(name))
