"""What the state machine of a process makes of an end: asked for, a failure or a crash."""

import errno
import signal

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode
from launcher.run.processes.machine_events import (
    Exited,
    MachineAction,
    MachineCommand,
    ProcessState,
    ReportExit,
    SignalSent,
)
from tests.run.unit.machines import INT, KILL, TERM, exited, machine, running


@pytest.mark.parametrize(
    ("outcome", "text"),
    [
        (Outcome(returncode=3), "exit code 3"),
        (Outcome(returncode=-11), "SIGSEGV"),
        (Outcome(returncode=-40), "signal 40"),
        (Outcome(returncode=-6, core_dumped=True), "SIGABRT, core dumped"),
        (
            Outcome(returncode=-9, out_of_memory=True),
            "SIGKILL, out of memory",
        ),
        (Outcome(spawn_errno=errno.EACCES), "could not be started: Permission denied"),
    ],
)
def test_an_outcome_reads_as_a_person_would_say_it(outcome, text):
    assert str(outcome) == text


@pytest.mark.parametrize(
    ("signum", "code"), [(KILL, -9), (TERM, -15), (TERM, 143), (INT, 0), (INT, 1)]
)
@pytest.mark.parametrize("is_starting", [False, True])
def test_an_end_by_a_signal_that_a_person_sent_is_asked_and_not_repeated(
    signum: int, code: int, is_starting: bool
):
    one = running(mode=RestartMode.ALWAYS)
    if is_starting:
        one = machine(mode=RestartMode.ALWAYS)
        one.handle(MachineCommand.START, 0.0)
    assert one.handle(SignalSent(signum), 1.0) == []
    outcome = Outcome(returncode=code)
    assert one.handle(exited(code), 1.5) == [
        ReportExit(outcome, asked=True, retry_in_s=None, sent=True)
    ]
    assert one.state is ProcessState.STOPPED


def test_an_exit_long_after_a_signal_or_by_another_one_was_not_requested():
    for signum, code, later_s in [(INT, 1, 60.0), (signal.SIGUSR1, -11, 1.0), (INT, -11, 1.0)]:
        one = running()
        one.handle(SignalSent(signum), 1.0)
        (end,) = one.handle(exited(code), 1.0 + later_s)
        assert end == ReportExit(Outcome(returncode=code), asked=False, retry_in_s=None)


def test_a_signal_before_the_last_restart_is_forgotten():
    one = running(mode=RestartMode.ALWAYS)
    one.handle(SignalSent(signal.SIGUSR1), 1.0)
    one.handle(exited(3), 2.0)
    one.handle(MachineCommand.TICK, 3.0)
    one.handle(MachineCommand.STARTED, 3.0)
    (end,) = one.handle(exited(-signal.SIGUSR1), 4.0)
    assert not end.asked


# ---- crashes in answer to a stop


@pytest.mark.parametrize(
    "stop", [MachineCommand.STOP, MachineCommand.USER_STOP, MachineCommand.SKIP_GRACE]
)
@pytest.mark.parametrize("signum", [signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, KILL])
def test_an_end_in_a_stop_by_a_signal_that_nobody_sent_is_a_death(
    stop: MachineCommand, signum: int
):
    one = running(mode=RestartMode.ALWAYS)
    one.handle(stop, 0.0)
    (end,) = one.handle(exited(-signum), 0.1)
    assert isinstance(end, ReportExit)
    assert (end.asked, end.retry_in_s, end.crashed, end.has_died) == (False, None, True, True)
    assert not end.is_final, "it was to end"
    assert one.state is ProcessState.STOPPED, "nor does it start again"


@pytest.mark.parametrize("code", [0, 1, 7, 139, -1, -2, -13, -14, -15, -26, -27])
def test_other_ends_in_a_stop_are_as_requested(code: int):
    """Also by signals that ask for an end, or tell that a reader has gone, and by own timers."""
    one = running()
    one.handle(MachineCommand.STOP, 0.0)
    assert one.handle(exited(code), 0.1) == [ReportExit(Outcome(returncode=code), True, None)]


def test_a_signal_that_was_sent_to_it_in_this_life_may_end_it():
    one = running()
    one.handle(SignalSent(signal.SIGUSR1, by_user=False), 0.0)
    one.handle(MachineCommand.STOP, 1.0)
    one.handle(SignalSent(signal.SIGABRT), 2.0)
    for signum in (signal.SIGUSR1, signal.SIGABRT):
        assert not one._has_crashed(Outcome(returncode=-signum))
    assert one._has_crashed(Outcome(returncode=-KILL))
    one.handle(MachineCommand.SKIP_GRACE, 3.0)
    one.handle(MachineCommand.SKIP_GRACE, 3.0)
    assert not one._has_crashed(Outcome(returncode=-KILL)), "now it was"
    one.handle(exited(-KILL), 4.0)
    one.handle(MachineCommand.START, 5.0)
    one.handle(MachineCommand.STARTED, 5.0)
    one.handle(MachineCommand.STOP, 6.0)
    for signum in (signal.SIGUSR1, signal.SIGABRT, KILL):
        assert one._has_crashed(Outcome(returncode=-signum)), "this is another life"
    one.handle(exited(-KILL), 7.0)
    one.handle(MachineCommand.START, 8.0)
    one.handle(SignalSent(signal.SIGUSR1), 8.0)
    one.handle(MachineCommand.STOP, 8.0)
    one.handle(MachineCommand.STARTED, 9.0)
    assert not one._has_crashed(Outcome(returncode=-signal.SIGUSR1))
    assert one._has_crashed(Outcome(returncode=-signal.SIGABRT)), "nor is this one"


def test_a_crash_when_it_is_restarted_is_a_death_and_it_starts_again():
    one = running()
    one.handle(MachineCommand.RESTART, 0.0)
    (end,) = one.handle(exited(-11), 0.1)
    assert end == ReportExit(Outcome(returncode=-11), False, 0.0, crashed=True)
    assert one.handle(MachineCommand.TICK, 0.1) == [MachineAction.SPAWN]


def test_what_is_lost_with_its_host_has_not_crashed():
    one = running()
    one.handle(MachineCommand.STOP, 0.0)
    (end,) = one.handle(Exited(Outcome(returncode=-9, lost_with="bot1")), 0.1)
    assert isinstance(end, ReportExit) and end.asked
