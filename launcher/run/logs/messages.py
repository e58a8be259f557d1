"""Log messages about processes.

Messages of ROS 2 (CONFORMANCE 1.16, 1.22, 1.23) are kept word for word: scripts search for them.
"""

from __future__ import annotations

import errno
import os
import signal
from collections.abc import Iterable

from launcher.base.errors import ExitCode
from launcher.base.model.events import Outcome, refusal, signal_name
from launcher.base.model.record import Record
from launcher.base.text import count
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import Escalate, ProcessState, ReportExit
from launcher.run.processes.process import Process

_RUN = ("-m", "launcher", "run")  # what finds the executable on hosts with systemd
LAST_LINES = 10  # of the process that failed first, in the summary


class Line(Record):
    """A level (INFO, WARNING, ERROR) and a text without a newline."""

    level: str
    text: str


def started(pid: int, host: str = "") -> Line:
    return Line("INFO", f"process started with pid [{pid}]{f' on {host}' if host else ''}")


def adopted(state: ProcessState, pid: int, host: str, age_s: float, restarts: int) -> Line:
    """What became of a process before its run was attached to."""
    times = f", {count(restarts, 'restart')} so far" if restarts else ""
    if pid > 0:
        return Line("INFO", f"runs on {host} with pid [{pid}] for {age_s:.0f} s{times}")
    return Line("WARNING", f"does not run on {host} ({state.value}){times}")


def signalled(name: str, signum: int) -> Line:
    return Line("INFO", f"sending signal '{signal_name(signum)}' to process[{name}]")


def escalated(name: str, step: Escalate, *, by_user: bool = False) -> Line:
    """It did not exit, at the end of the run or (`by_user`) when a user stopped it."""
    return Line(
        "WARNING" if by_user else "ERROR",
        f"process[{name}] failed to terminate '{step.waited_s:.3g}' seconds after receiving "
        f"'{step.after.name}', escalating to '{step.to.name}'",
    )


def stuck(name: str, pid: int, waited_s: float, how: str) -> Line:
    return Line(
        "ERROR", f"process[{name}] [{pid}] still exists {waited_s:.3g} s after SIGKILL: {how}"
    )


def ended(process: Process, pid: int, end: ReportExit, *, by_user: bool = False) -> Line:
    """It exited: by itself, or because the launcher or (`by_user`) a user has stopped it."""
    code = end.outcome.returncode
    if code == 0:
        return Line("INFO", f"process has finished cleanly [pid {pid}]")
    detail = "" if code is None or code >= 0 else f" ({end.outcome})"
    is_wanted = end.sent or code != -9 or process.spec.stop.steps[0][0] == signal.SIGKILL
    if end.asked and (by_user or is_wanted):
        level = "INFO" if is_wanted else "WARNING"
        return Line(level, f"process was stopped [pid {pid}, {end.outcome}]")
    text = f"process has died [pid {pid}, exit code {code}, cmd '{process.command_line}'].{detail}"
    is_refusal = code == ExitCode.USAGE and process.words_there[1:4] == _RUN
    return Line("ERROR", text + (f" {_repair(process)}" if is_refusal else ""))


def not_started(process: Process, number: int, what: str) -> Line:
    """Spawning failed."""
    text = f"process could not be started: {refusal(number, what)}, cmd '{process.command_line}'"
    if process.host is not None and number == errno.ENOENT:
        text += f"; {_repair(process)}"
    if process.host is None and not what and not process.history.refusals:
        text += _fault(process)
    return Line("ERROR", text)


def _fault(process: Process) -> str:
    """What is wrong with a program, as far as its file shows."""
    from launcher.packages.program_fault import fault_of  # only after a failure

    spec = process.spec
    beside = os.path.dirname(spec.place.rpartition(":")[0]) or None
    fault = None if spec.shell else fault_of(spec.argv[0], spec.env, spec.cwd, beside)
    return "" if fault is None else f"; {fault}"


def _repair(process: Process) -> str:
    return f"if {process.host_name} lacks it: python -m launcher hosts sync"


def no_longer_read(name: str) -> str:
    return (
        f"the output of what {name} has left running is not read any more: it ends by SIGPIPE when "
        "it writes (the limit of open files, ulimit -n, is too low for all that is left)"
    )


def start_cancelled() -> Line:
    return Line("INFO", "process was not started: stopped while it was queued")


def first_failure(process: Process, outcome: Outcome) -> str:
    """The summary at the end: which process failed first, and the last lines of its output."""
    host = f" on {process.host_name}" if process.host is not None else ""
    head = f"first unexpected exit: {process.name}{host} ({outcome})"
    note = process.history.core_note
    after = [f"  {note}"] if note else []
    lines = process.last_lines(LAST_LINES)
    if not lines:
        return "\n".join([f"{head}; it had printed nothing", *after])
    return "\n".join([f"{head}; its last lines:", *(f"    {line}" for line in lines), *after])


def waiting_for(processes: Iterable[Process], now: float) -> str:
    """The processes that have not exited, with the next signal for each."""
    alive = (process for process in processes if process.is_awaited)
    waits = ", ".join(f"{p.name}{_unreachable(p) or _next_step(p.machine, now)}" for p in alive)
    return f"still waiting for {waits}"


def _unreachable(process: Process) -> str:
    if process.host is None or process.host.unreachable_s is None:
        return ""
    return f" ({process.host.name} is unreachable, {process.host.unreachable_s:.0f} s)"


def _next_step(machine: ProcessMachine, now: float) -> str:
    if machine.next_signal is None:
        return ""
    signum, at_s = machine.next_signal
    return f" ({signum.name} in {max(0.0, at_s - now):.1f} s)"


def restarts_in(delay_s: float, restarts: int, limit: int | None) -> Line:
    of = "" if limit is None else f" of {limit}"
    return Line("INFO", f"restart {restarts + 1}{of} in {delay_s:.3g} s")


def restarts_used_up(machine: ProcessMachine) -> Line:
    window_s = machine.restart.window_s
    within = "" if window_s is None else f" within {window_s:g} s"
    after = f"after {count(machine.restarts, 'restart')}{within}"
    if machine.state is ProcessState.FATAL:
        return Line("ERROR", f"process is given up {after}")
    return Line("INFO", f"process is not restarted again {after}")
