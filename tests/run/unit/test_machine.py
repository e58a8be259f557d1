"""The state machine of a process: starting, stopping and restarting, on a simulated clock."""

import errno
import signal

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy, StopPolicy
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    Escalate,
    MachineAction,
    MachineCommand,
    ProcessState,
    ReportExit,
    ReportStuck,
    Signal,
    SpawnError,
)
from tests.run.unit.machines import INT, KILL, TERM, exited, machine, running


def test_a_start_spawns_and_a_started_process_runs():
    one = machine()
    assert one.handle(MachineCommand.START, 0.0) == [MachineAction.SPAWN]
    assert one.state is ProcessState.STARTING
    assert one.handle(MachineCommand.STARTED, 0.0) == []
    assert one.state is ProcessState.RUNNING


def test_a_stubborn_process_is_killed_after_both_grace_periods():
    one = running()
    assert one.handle(MachineCommand.STOP, 1.0) == [Signal(INT)]
    assert one.handle(MachineCommand.TICK, 5.9) == []
    assert one.handle(MachineCommand.TICK, 6.0) == [Escalate(INT, 5.0, TERM), Signal(TERM)]
    assert one.handle(MachineCommand.TICK, 11.0) == [Escalate(TERM, 5.0, KILL), Signal(KILL)]


def test_a_process_that_got_sigint_from_elsewhere_gets_what_follows_it():
    one = running()
    assert one.handle(MachineCommand.INTERRUPTED, 1.0) == []
    assert one.state is ProcessState.STOPPING
    assert one.handle(MachineCommand.TICK, 6.0) == [Escalate(INT, 5.0, TERM), Signal(TERM)]


def test_an_interrupted_process_whose_stop_begins_with_another_signal_gets_that():
    one = ProcessMachine(RestartPolicy(), StopPolicy(polite=((TERM, 3.0),)))
    one.handle(MachineCommand.START, 0.0)
    one.handle(MachineCommand.STARTED, 0.0)
    assert one.handle(MachineCommand.INTERRUPTED, 1.0) == [Signal(TERM)]


def test_a_process_that_only_starts_when_the_others_were_interrupted_gets_sigint():
    one = machine()
    one.handle(MachineCommand.START, 0.0)
    assert one.handle(MachineCommand.INTERRUPTED, 0.0) == []
    assert one.handle(MachineCommand.STARTED, 1.0) == [Signal(INT)]


def test_a_process_that_survives_sigkill_is_reported_once_and_may_still_exit():
    one = running()
    one.handle(MachineCommand.STOP, 0.0)
    one.handle(MachineCommand.TICK, 5.0)
    one.handle(MachineCommand.TICK, 10.0)
    assert one.is_killing and not one.is_stuck
    assert one.handle(MachineCommand.TICK, 15.0) == [ReportStuck(5.0)]
    assert one.is_stuck
    assert one.deadline is None
    assert one.handle(MachineCommand.SKIP_GRACE, 16.0) == []
    assert one.handle(MachineCommand.START, 16.0) == [], "there would be two"
    one.handle(exited(-9), 20.0)
    assert one.state is ProcessState.STOPPED and not one.is_stuck


def test_a_queued_start_can_be_cancelled():
    one = machine()
    one.handle(MachineCommand.START, 0.0)
    one.handle(MachineCommand.STOP, 0.0)
    assert one.handle(MachineCommand.START_CANCELLED, 0.0) == []
    assert one.state is ProcessState.STOPPED
    assert one.handle(MachineCommand.START, 1.0) == [MachineAction.SPAWN]


def test_a_custom_stop_policy_is_followed_step_by_step():
    policy = StopPolicy(polite=((signal.SIGUSR1, 0.5),))
    one = ProcessMachine(RestartPolicy(), policy)
    one.handle(MachineCommand.START, 0.0)
    one.handle(MachineCommand.STARTED, 0.0)
    assert one.handle(MachineCommand.STOP, 1.0) == [Signal(signal.SIGUSR1)]
    assert one.handle(MachineCommand.TICK, 1.5) == [
        Escalate(signal.SIGUSR1, 0.5, KILL),
        Signal(KILL),
    ]


def test_hurrying_takes_the_next_step_at_once_and_says_how_long_it_waited():
    one = running()
    one.handle(MachineCommand.STOP, 1.0)
    assert one.handle(MachineCommand.SKIP_GRACE, 3.0) == [Escalate(INT, 2.0, TERM), Signal(TERM)]
    assert one.handle(MachineCommand.SKIP_GRACE, 3.5) == [Escalate(TERM, 0.5, KILL), Signal(KILL)]
    assert one.handle(MachineCommand.SKIP_GRACE, 3.6) == []


def test_a_requested_exit_is_no_failure_and_never_restarts():
    one = running(mode=RestartMode.ALWAYS)
    one.handle(MachineCommand.STOP, 0.0)
    assert one.handle(exited(-2), 0.1) == [ReportExit(Outcome(returncode=-2), True, None)]
    assert one.state is ProcessState.STOPPED


def test_a_stop_that_overtakes_the_spawn_is_delivered_when_there_is_a_process():
    one = machine()
    one.handle(MachineCommand.START, 0.0)
    assert one.handle(MachineCommand.STOP, 0.0) == []
    assert one.handle(MachineCommand.STARTED, 0.1) == [Signal(INT)]
    assert one.running_since == 0.1


def test_only_a_complete_start_gives_a_time():
    one = machine(mode=RestartMode.ALWAYS, delay_s=1.0)
    assert one.running_since is None
    one.handle(MachineCommand.START, 1000.0)
    assert one.running_since is None
    one.handle(MachineCommand.STARTED, 1001.0)
    one.handle(exited(0), 1002.0)
    assert one.running_since == 1001.0
    one.handle(MachineCommand.TICK, 1003.0)
    assert (one.state, one.running_since) == (ProcessState.STARTING, None)


def test_one_that_ends_before_its_program_began_had_no_quiet_time():
    one = machine(mode=RestartMode.ALWAYS, delay_s=1.0, quiet_s=30.0, backoff_max_s=8.0)
    delays = []
    for now in (1000.0, 2000.0, 3000.0):
        one.handle(MachineCommand.TICK if delays else MachineCommand.START, now)
        (end,) = one.handle(exited(1), now)
        delays.append(end.retry_in_s)
    assert delays == [1.0, 2.0, 4.0]


@pytest.mark.parametrize(
    ("mode", "code", "state"),
    [
        (RestartMode.NEVER, 0, ProcessState.EXITED),
        (RestartMode.NEVER, 1, ProcessState.EXITED),
        (RestartMode.ON_FAILURE, 0, ProcessState.EXITED),
        (RestartMode.ON_FAILURE, -11, ProcessState.BACKOFF),
        (RestartMode.ALWAYS, 0, ProcessState.BACKOFF),
    ],
)
def test_the_restart_mode_decides_after_an_end(mode, code, state):
    one = running(mode=mode)
    one.handle(exited(code), 1.0)
    assert one.state is state


def test_a_restart_waits_for_its_delay_in_backoff():
    one = running(mode=RestartMode.ALWAYS, delay_s=1.5)
    one.handle(exited(1), 2.0)
    assert one.handle(MachineCommand.TICK, 3.4) == []
    assert one.handle(MachineCommand.TICK, 3.5) == [MachineAction.SPAWN]
    assert one.restarts == 1


def test_a_restart_that_was_asked_for_stops_and_starts_at_once():
    one = running()
    assert one.handle(MachineCommand.RESTART, 1.0) == [Signal(INT)]
    assert one.handle(exited(0), 1.2) == [ReportExit(Outcome(returncode=0), True, 0.0)]
    assert one.handle(MachineCommand.TICK, 1.2) == [MachineAction.SPAWN]


def test_a_stop_after_a_restart_means_a_stop():
    one = running()
    one.handle(MachineCommand.RESTART, 1.0)
    assert one.handle(MachineCommand.STOP, 1.1) == []
    one.handle(exited(0), 1.2)
    assert one.state is ProcessState.STOPPED


@pytest.mark.parametrize("stop", [MachineCommand.STOP, MachineCommand.USER_STOP])
def test_a_budget_does_not_restart_what_is_being_stopped(stop: MachineCommand):
    one = running()
    one.handle(stop, 1.0)
    assert one.handle(MachineCommand.RESTART, 1.1) == []
    assert one.handle(exited(0), 1.2) == [ReportExit(Outcome(returncode=0), True, None)]
    assert one.state is ProcessState.STOPPED


def test_a_stop_in_backoff_ends_it_without_a_signal():
    one = running(mode=RestartMode.ALWAYS, delay_s=1.5)
    one.handle(exited(1), 2.0)
    assert one.handle(MachineCommand.STOP, 2.1) == []
    assert one.state is ProcessState.STOPPED
    assert one.handle(MachineCommand.TICK, 9.0) == []


def test_used_up_restarts_are_fatal():
    one = running(mode=RestartMode.ALWAYS, max_restarts=1)
    one.handle(exited(1), 1.0)
    one.handle(MachineCommand.TICK, 1.0)
    one.handle(MachineCommand.STARTED, 1.0)
    assert one.handle(exited(1), 2.0) == [ReportExit(Outcome(returncode=1), False, None)]
    assert one.state is ProcessState.FATAL


def delays_of_a_crash_loop(one: ProcessMachine, lives_s: list[float]) -> list[float | None]:
    """What it waits after each life; None where it gives up."""
    now = 0.0
    delays = []
    for life_s in lives_s:
        now += life_s
        (end,) = one.handle(exited(1), now)
        delays.append(end.retry_in_s)
        now += end.retry_in_s or 0.0
        one.handle(MachineCommand.TICK, now)
        one.handle(MachineCommand.STARTED, now)
    return delays


BACKOFF = {"mode": RestartMode.ON_FAILURE, "delay_s": 0.5, "backoff_max_s": 3.0}


def test_the_delay_doubles_up_to_its_limit():
    assert delays_of_a_crash_loop(running(**BACKOFF), [0.1] * 5) == [0.5, 1.0, 2.0, 3.0, 3.0]


def test_a_quiet_time_begins_the_doubling_anew():
    delays = delays_of_a_crash_loop(running(**BACKOFF, quiet_s=10.0), [0.1, 0.1, 10.1, 0.1])
    assert delays == [0.5, 1.0, 0.5, 1.0]


def test_chance_makes_a_delay_longer_by_its_share():
    assert delays_of_a_crash_loop(running(**BACKOFF, jitter=0.2), [0.1]) == [0.5 * 1.1]


def test_a_restart_budget_with_a_window_counts_recent_failures_only():
    policy = {"mode": RestartMode.ALWAYS, "max_restarts": 2, "window_s": 60.0}
    assert delays_of_a_crash_loop(running(**policy), [1.0, 1.0, 1.0]) == [0.0, 0.0, None]
    assert delays_of_a_crash_loop(running(**policy), [40.0] * 6) == [0.0] * 6


def test_a_program_that_is_missing_is_fatal_at_once_even_with_restarts():
    one = machine(mode=RestartMode.ALWAYS)
    one.handle(MachineCommand.START, 0.0)
    one.handle(SpawnError(errno.ENOENT), 0.0)
    assert one.state is ProcessState.FATAL


def test_too_many_open_files_are_tried_again_but_not_in_a_busy_loop():
    one = machine(mode=RestartMode.ALWAYS)
    one.handle(MachineCommand.START, 0.0)
    one.handle(SpawnError(errno.EMFILE), 0.0)
    assert one.handle(MachineCommand.TICK, 0.9) == []
    assert one.handle(MachineCommand.TICK, 1.0) == [MachineAction.SPAWN]
