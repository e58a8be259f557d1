"""What a user does to a process: stopping, starting, suspending and signalling it."""

import errno
import signal

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy, StopPolicy
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    Exited,
    MachineAction,
    MachineCommand,
    ProcessState,
    Signal,
    SignalSent,
    SpawnError,
)
from tests.run.unit.machines import INT, KILL, TERM, exited, running


def test_a_process_is_held_from_a_users_stop_until_it_runs_again():
    one = running(mode=RestartMode.ALWAYS)
    assert one.handle(MachineCommand.USER_STOP, 0.0) == [Signal(INT)]
    assert one.is_held
    one.handle(exited(-2), 0.1)
    assert one.is_held
    assert one.handle(MachineCommand.USER_START, 1.0) == [MachineAction.SPAWN]
    assert one.is_held, "the run must not end with an attempt that fails"
    one.handle(MachineCommand.STARTED, 1.0)
    assert not one.is_held


def test_a_users_start_that_fails_leaves_it_held():
    one = running()
    one.handle(exited(0), 0.1)
    assert not one.is_held
    one.handle(MachineCommand.USER_START, 1.0)
    one.handle(SpawnError(errno.ENOENT), 1.0)
    assert one.state is ProcessState.FATAL and one.is_held


def test_a_user_cannot_hold_what_does_not_run():
    one = running()
    one.handle(exited(0), 0.1)
    assert one.handle(MachineCommand.USER_STOP, 1.0) == []
    assert not one.is_held


def test_a_users_stop_cancels_a_restart_and_holds():
    one = running(mode=RestartMode.ALWAYS, delay_s=5.0)
    one.handle(exited(0), 0.1)
    assert one.handle(MachineCommand.USER_STOP, 1.0) == []
    assert one.state is ProcessState.STOPPED and one.is_held


def test_an_end_by_a_users_signal_holds_it():
    one = running()
    one.handle(SignalSent(KILL), 0.0)
    assert not one.is_held
    one.handle(exited(-9), 0.1)
    assert one.is_held and not one.had_to_be_killed


def test_a_signal_of_the_launch_file_is_no_user_request():
    one = running(mode=RestartMode.ON_FAILURE)
    one.handle(SignalSent(TERM, by_user=False), 0.0)
    assert one.handle(exited(-15), 0.1)[0].asked is False


def test_only_a_sigkill_that_no_user_caused_counts_as_one():
    for event, counts in ((MachineCommand.STOP, True), (MachineCommand.USER_STOP, False)):
        one = running()
        one.handle(event, 0.0)
        one.handle(MachineCommand.TICK, 5.0)
        assert not one.had_to_be_killed
        one.handle(MachineCommand.TICK, 10.0)
        assert one.had_to_be_killed is counts
    one.handle(MachineCommand.TICK, 15.0)
    assert one.is_stuck and one.had_to_be_killed


def test_suspending_and_resuming():
    one = running()
    assert one.handle(MachineCommand.SUSPEND, 0.0) == [Signal(signal.SIGSTOP)]
    assert one.is_suspended
    assert one.handle(MachineCommand.RESUME, 0.0) == [Signal(signal.SIGCONT)]
    assert not one.is_suspended
    one.handle(exited(0), 0.1)
    assert one.handle(MachineCommand.SUSPEND, 0.2) == [] and not one.is_suspended


@pytest.mark.parametrize("by_user", [True, False])
def test_a_suspended_process_is_woken_by_a_polite_signal(by_user: bool):
    one = running()
    assert one.handle(SignalSent(TERM, by_user=by_user), 0.0) == []
    one.handle(MachineCommand.SUSPEND, 0.0)
    assert one.handle(SignalSent(signal.SIGUSR1, by_user=by_user), 0.0) == []
    assert one.is_suspended
    assert one.handle(SignalSent(TERM, by_user=by_user), 0.0) == [MachineAction.WAKE]
    assert not one.is_suspended


def test_a_users_own_sigstop_and_sigcont_count_as_suspending_and_resuming():
    one = running()
    one.handle(SignalSent(signal.SIGSTOP), 0.0)
    assert one.is_suspended
    one.handle(SignalSent(signal.SIGCONT), 0.0)
    assert not one.is_suspended
    one.handle(MachineCommand.SUSPEND, 0.0)
    one.handle(MachineCommand.STOP, 0.0)
    assert not one.is_suspended, "a polite stop wakes it"
    assert Signal(INT).needs_wake and not Signal(KILL).needs_wake


def test_skipping_the_grace_period_of_what_was_not_stopped_stops_it():
    one = running()
    assert one.handle(MachineCommand.SKIP_GRACE, 0.0) == [Signal(INT)]
    assert one.state is ProcessState.STOPPING


def test_a_new_stop_policy_leaves_a_stop_that_is_under_way_alone():
    machine = ProcessMachine(RestartPolicy(), StopPolicy(polite=((signal.SIGINT, 9.0),)))
    machine.handle(MachineCommand.START, 0.0)
    machine.handle(MachineCommand.STARTED, 0.0)
    machine.handle(MachineCommand.USER_STOP, 1.0)
    machine.apply(RestartPolicy(), StopPolicy(polite=()))
    assert machine.next_signal == (signal.SIGKILL, 10.0)
    machine.handle(Exited(Outcome(returncode=0)), 2.0)
    assert machine.stop.steps[0][0] is signal.SIGKILL
