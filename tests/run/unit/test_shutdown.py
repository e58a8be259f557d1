"""The shutdown of a run as a state machine: reasons, sequence and exit code."""

from __future__ import annotations

import signal

import pytest

from launcher.base.errors import ExitCode
from launcher.base.model.events import Outcome, ShutdownAsked, SignalReceived
from launcher.base.model.spec import ProcessSpec, RestartMode, RestartPolicy
from launcher.run.ending.shutdown_machine import (
    OUTPUT_CLOSED,
    BudgetExceeded,
    EndLeftovers,
    HostFailed,
    Idle,
    Interrupted,
    Notify,
    Occurrence,
    ProcessEnded,
    ShutdownDecided,
    ShutdownMachine,
    ShutdownOrder,
    StopAll,
    StopRequested,
    WriteLog,
)
from launcher.run.processes.machine_events import (
    Exited,
    MachineCommand,
    ProcessState,
    ReportExit,
    SignalSent,
)
from launcher.run.processes.process import Process

INT, TERM, HUP, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL
SKIP = ShutdownOrder.SKIP_GRACE_PERIODS
IDLE = Idle(expects_more=False)
DIED = ReportExit(Outcome(returncode=1), asked=False, retry_in_s=None)


def process(number: int = 1, **restart: object) -> Process:
    name = f"robot-{number}"
    spec = ProcessSpec(
        name=name, label="robot", argv=(name,), env={}, restart=RestartPolicy(**restart)
    )
    return Process(number, spec, number=number, prefix=b"")


def running(number: int = 1, **restart: object) -> Process:
    one = process(number, **restart)
    one.machine.handle(MachineCommand.START, 0.0)
    one.machine.handle(MachineCommand.STARTED, 0.0)
    return one


def killed(*, by_user: bool) -> Process:
    """One that did not end before SIGKILL."""
    one = running()
    one.machine.handle(MachineCommand.USER_STOP if by_user else MachineCommand.STOP, 0.0)
    one.machine.handle(MachineCommand.SKIP_GRACE, 0.0)
    one.machine.handle(MachineCommand.SKIP_GRACE, 0.0)
    one.machine.handle(Exited(Outcome(returncode=-9)), 0.0)
    return one


def stuck() -> Process:
    one = running()
    one.machine.handle(MachineCommand.STOP, 0.0)
    for now in (5.0, 10.0, 15.0):
        one.machine.handle(MachineCommand.TICK, now)
    assert one.machine.is_stuck
    return one


# ---- reasons


def test_a_signal_goes_to_the_interpreter_whose_answer_stops_everything():
    run = ShutdownMachine([running()])
    said = WriteLog("WARNING", "user interrupted with ctrl-c (SIGINT)")
    assert run.handle(Interrupted(INT), 1.0) == [said, Notify(SignalReceived(signum=INT))]
    assert run.is_stopping
    assert run.handle(ShutdownDecided("ctrl-c"), 1.0) == [StopAll("ctrl-c")]
    assert run.handle(ShutdownDecided("another"), 1.0) == []
    assert run.handle(Occurrence.TICK, 1.0) == [], "it has been stopped once"


def test_a_shutdown_of_interrupted_processes_says_so():
    run = ShutdownMachine([running()])
    decided = ShutdownDecided("ctrl-c", is_interrupted=True)
    assert run.handle(decided, 1.0)[-1] == StopAll("ctrl-c", is_interrupted=True)


def test_a_signal_stops_everything_even_if_the_interpreter_does_not_answer():
    run = ShutdownMachine([running()])
    run.handle(Interrupted(TERM), 1.0)
    assert run.deadline == 1.0
    assert run.handle(IDLE, 1.0) == []
    assert run.handle(Occurrence.TICK, 1.0) == [StopAll("SIGTERM")]


@pytest.mark.parametrize("signum", [INT, TERM, HUP])
def test_every_further_signal_skips_the_grace_periods(signum: int):
    run = ShutdownMachine([running()])
    run.handle(Interrupted(INT), 0.0)
    run.handle(ShutdownDecided("ctrl-c"), 0.0)
    for _ in range(3):
        said, skip = run.handle(Interrupted(signum), 1.0)
        assert isinstance(said, WriteLog) and said.text.endswith("again, not waiting any longer")
        assert skip == SKIP


def test_a_signal_after_another_reason_skips_the_grace_periods():
    run = ShutdownMachine([running()])
    run.handle(ShutdownDecided("over"), 0.0)
    assert SKIP in run.handle(Interrupted(INT), 1.0)


def test_the_sighup_of_a_terminal_whose_closed_output_was_noticed_first_is_no_second_signal():
    run = ShutdownMachine([running()])
    run.handle(Occurrence.OUTPUT_CLOSED, 0.0)
    run.handle(Occurrence.TICK, 0.0)
    run.handle(ShutdownDecided(OUTPUT_CLOSED), 0.0)
    assert run.handle(Interrupted(HUP), 0.1) == []
    assert SKIP in run.handle(Interrupted(HUP), 0.2), "that is the second one"


def test_any_other_sighup_while_it_is_stopping_does_not_wait():
    run = ShutdownMachine([running()])
    run.handle(ShutdownDecided("over"), 0.0)
    assert SKIP in run.handle(Interrupted(HUP), 0.1)


def test_a_sighup_of_a_closed_terminal_stops_a_run_that_was_not_stopping():
    run = ShutdownMachine([running()])
    run.handle(Occurrence.OUTPUT_CLOSED, 0.0)
    assert Notify(SignalReceived(signum=HUP)) in run.handle(Interrupted(HUP), 0.0)


@pytest.mark.parametrize(
    ("event", "reason"),
    [
        (StopRequested("timeout of 7 s reached"), "timeout of 7 s reached"),
        (Occurrence.OUTPUT_CLOSED, OUTPUT_CLOSED),
        (BudgetExceeded("robot-1", "it uses too much"), "robot-1 is over its budget"),
        (ProcessEnded("robot-1", DIED, is_required=True), "robot-1 is required and has exited"),
    ],
)
def test_other_reasons_wait_for_the_next_tick_and_are_announced(event, reason: str):
    run = ShutdownMachine([running()])
    assert run.handle(event, 3.0) == []
    assert not run.is_stopping and run.deadline == 3.0
    said, told = run.handle(Occurrence.TICK, 3.0)
    assert said == WriteLog("INFO", f"{reason}: shutting down")
    assert told == Notify(ShutdownAsked(reason=reason))
    assert run.handle(ShutdownDecided(reason), 3.0) == [StopAll(reason)]


def test_the_first_of_several_reasons_counts():
    run = ShutdownMachine([running()])
    run.handle(StopRequested("a"), 0.0)
    run.handle(StopRequested("b"), 0.0)
    assert WriteLog("INFO", "a: shutting down") in run.handle(Occurrence.TICK, 0.0)
    run.handle(StopRequested("c"), 0.0)
    run.handle(ShutdownDecided("a"), 0.0)
    assert run.handle(Occurrence.TICK, 0.5) == []


def test_a_pending_reason_is_dropped_if_the_launch_file_shuts_down_first():
    run = ShutdownMachine([running()])
    run.handle(StopRequested("a"), 0.0)
    said = WriteLog("INFO", "shutdown requested by the launch file: b")
    assert run.handle(ShutdownDecided("b"), 0.0) == [said, StopAll("b")]
    assert run.end_reason == "b"
    assert run.handle(Occurrence.TICK, 0.0) == []


def test_what_a_script_has_asked_for_is_no_request_of_the_launch_file():
    reason = "LaunchService.shutdown() called"
    assert ShutdownMachine([running()]).handle(ShutdownDecided(reason), 0.0) == [StopAll(reason)]


@pytest.mark.parametrize(
    ("end", "required", "any_dies"),
    [
        (DIED, True, True),
        (ReportExit(Outcome(returncode=0), asked=False, retry_in_s=None), True, False),
        (ReportExit(Outcome(returncode=1), asked=False, retry_in_s=0.5), False, False),
        (ReportExit(Outcome(returncode=-2), asked=True, retry_in_s=None), False, False),
        (ReportExit(Outcome(spawn_errno=2), asked=False, retry_in_s=None), True, True),
    ],
)
def test_an_exit_stops_the_run_if_it_is_final_and_required_or_a_failure(
    end: ReportExit, required: bool, any_dies: bool
):
    run = ShutdownMachine([])
    run.handle(ProcessEnded("robot-1", end, is_required=True), 0.0)
    assert (run.deadline is not None) is required
    run = ShutdownMachine([], exit_when_any_dies=True)
    run.handle(ProcessEnded("robot-1", end), 0.0)
    assert (run.deadline is not None) is any_dies
    run = ShutdownMachine([])
    run.handle(ProcessEnded("robot-1", end), 0.0)
    assert run.deadline is None


# ---- the course


def test_remaining_processes_are_reported_once_a_second():
    one = running()
    run = ShutdownMachine([one])
    run.handle(ShutdownDecided("over"), 0.0)
    one.machine.handle(MachineCommand.STOP, 0.0)
    assert run.handle(Occurrence.TICK, 0.9) == []
    assert run.handle(Occurrence.TICK, 1.0) == [ShutdownOrder.REPORT_WAITING]
    assert run.deadline == 2.0
    one.machine.handle(Exited(Outcome(returncode=-2)), 1.5)
    assert run.handle(Occurrence.TICK, 2.0) == []
    assert run.deadline is None


def test_a_run_without_processes_is_over_and_leftovers_come_before_its_end():
    run = ShutdownMachine([])
    assert run.handle(IDLE, 0.0) == [EndLeftovers(0)]
    assert run.is_stopping
    assert run.handle(IDLE, 0.0) == [], "they are looked for once"
    assert run.handle(Occurrence.LEFTOVERS_GONE, 0.5) == [ShutdownOrder.FINISH]
    assert run.handle(Occurrence.LEFTOVERS_GONE, 0.5) == []


def test_the_end_is_not_reached_while_something_may_start():
    run = ShutdownMachine([])
    assert run.handle(Idle(expects_more=True), 0.0) == []
    assert run.handle(Idle(expects_more=False, is_loading=True), 0.0) == []
    assert not run.is_stopping


def test_a_component_that_is_being_loaded_does_not_hold_up_a_shutdown():
    run = ShutdownMachine([])
    run.handle(ShutdownDecided("over"), 0.0)
    assert run.handle(Idle(expects_more=True, is_loading=True), 0.0) == []
    assert run.handle(Idle(expects_more=False, is_loading=True), 0.0) == [EndLeftovers(0)]


def test_the_end_waits_for_processes_and_their_restarts():
    one = process(1, mode=RestartMode.ON_FAILURE, delay_s=1.0)
    run = ShutdownMachine([one])
    for event, state in (
        (MachineCommand.START, ProcessState.STARTING),
        (MachineCommand.STARTED, ProcessState.RUNNING),
        (Exited(Outcome(returncode=1)), ProcessState.BACKOFF),
    ):
        one.machine.handle(event, 0.0)
        assert one.machine.state is state
        assert run.handle(IDLE, 0.0) == []
    one.machine.handle(MachineCommand.STOP, 0.5)
    assert run.handle(IDLE, 0.5) == [EndLeftovers(0)]


@pytest.mark.parametrize("how", ["stopped", "killed with a signal"])
def test_what_a_user_has_stopped_keeps_the_run_alive_until_it_is_stopped(how: str):
    one = running()
    run = ShutdownMachine([one])
    one.machine.handle(MachineCommand.USER_STOP if how == "stopped" else SignalSent(KILL), 0.0)
    one.machine.handle(Exited(Outcome(returncode=-9)), 0.1)
    assert one.machine.is_held
    assert run.handle(IDLE, 0.1) == []
    run.handle(ShutdownDecided("over"), 1.0)
    assert run.handle(IDLE, 1.0) == [EndLeftovers(0)]


def test_nothing_waits_for_a_stuck_process_once_the_run_is_stopping():
    run = ShutdownMachine([stuck()])
    assert run.handle(IDLE, 15.0) == []
    run.handle(ShutdownDecided("over"), 15.0)
    assert run.handle(IDLE, 15.0) == [EndLeftovers(0)]


def test_earlier_signals_count_for_leftovers():
    one = running()
    run = ShutdownMachine([one])
    run.handle(Interrupted(INT), 0.0)
    run.handle(ShutdownDecided("ctrl-c"), 0.0)
    run.handle(Interrupted(INT), 0.1)
    run.handle(Interrupted(INT), 0.2)
    one.machine.handle(Exited(Outcome(returncode=0)), 0.3)
    assert run.handle(IDLE, 0.3) == [EndLeftovers(2)]
    assert SKIP in run.handle(Interrupted(INT), 0.4)


# ---- the exit code


def test_a_run_that_could_not_write_its_output_has_failed():
    run = ShutdownMachine([])
    assert run.exit_code() is ExitCode.OK
    assert run.exit_code(has_lost_output=True) is ExitCode.PROCESS_FAILED


@pytest.mark.parametrize("signum", [INT, TERM, HUP])
def test_a_stop_that_was_asked_for_is_no_failure(signum: int):
    run = ShutdownMachine([])
    run.handle(Interrupted(signum), 0.0)
    assert run.exit_code() is ExitCode.OK


@pytest.mark.parametrize(
    ("signums", "code"),
    [
        ((), ExitCode.PROCESS_FAILED),
        ((INT,), ExitCode.INTERRUPTED),
        ((INT, TERM), ExitCode.INTERRUPTED),
        ((TERM, INT), ExitCode.TERMINATED),
        ((HUP,), ExitCode.TERMINATED),
    ],
)
@pytest.mark.parametrize(
    ("processes", "events"),
    [
        ([], [ProcessEnded("robot-1", DIED, report="robot-1")]),
        ([], [BudgetExceeded("robot-1", "too much")]),
        ([], [Occurrence.LEFTOVERS_KILLED]),
        ([killed(by_user=False)], []),
        ([stuck()], []),
    ],
    ids=["died", "budget", "leftovers", "killed", "stuck"],
)
def test_a_failure_gives_the_code_of_the_first_signal(signums, code, processes, events):
    run = ShutdownMachine(processes)
    for event in (*events, *map(Interrupted, signums)):
        run.handle(event, 0.0)
    assert run.exit_code(has_lost_output=True) is code
    assert run.exit_code() is code


def test_a_process_that_a_user_stopped_may_need_sigkill():
    assert ShutdownMachine([killed(by_user=True)]).exit_code() is ExitCode.OK


def test_the_first_failure_is_kept():
    run = ShutdownMachine([])
    run.handle(
        ProcessEnded("a", ReportExit(Outcome(returncode=0), False, None), report="fine"), 0.0
    )
    run.handle(
        ProcessEnded("b", ReportExit(Outcome(returncode=1), True, None), report="asked"), 0.0
    )
    assert run.first_failure is None
    run.handle(ProcessEnded("c", DIED, report="c"), 0.0)
    run.handle(BudgetExceeded("d", "d"), 0.0)
    run.handle(ProcessEnded("e", DIED, report="e"), 0.0)
    assert run.first_failure == "c"


# ---- reasons and causes


@pytest.mark.parametrize("reason", ["idle", "exception in the launch file", "reason not given"])
def test_a_reason_that_the_launch_file_does_not_give_is_not_logged(reason: str):
    run = ShutdownMachine([running()])
    assert run.handle(ShutdownDecided(reason), 0.0) == [StopAll(reason)]


def test_there_is_a_cause_for_every_exit_code_but_0():
    run = ShutdownMachine([killed(by_user=False)])
    assert run.causes(has_lost_output=True) == ["robot-1 had to be killed", "output was lost"]
    run.handle(ProcessEnded("a", DIED, report="x"), 0.0)
    run.handle(ProcessEnded("b", DIED, report="x"), 0.0)
    run.handle(Occurrence.LEFTOVERS_KILLED, 0.0)
    assert run.causes() == [
        "a and b ended unexpectedly",
        "robot-1 had to be killed",
        "leftovers had to be killed",
    ]
    assert ShutdownMachine([running()]).causes() == []
    over = ShutdownMachine([running()])
    over.handle(BudgetExceeded("c", "report"), 0.0)
    assert over.causes() == ["c is over its budget"]


@pytest.mark.parametrize(
    ("names", "cause"),
    [
        ("aa", "a ended unexpectedly (exit code 1)"),
        ("aba", "a and b ended unexpectedly"),
        ("abc", "a, b and c ended unexpectedly"),
        ("abcd", "a, b, c and 1 more ended unexpectedly"),
        ("abcdea", "a, b, c and 2 more ended unexpectedly"),
    ],
)
def test_the_cause_names_several_processes_that_died(names: str, cause: str):
    run = ShutdownMachine([running()])
    for name in names:
        run.handle(ProcessEnded(name, DIED, report=name), 0.0)
    assert run.causes() == [cause]
    assert run.first_failure == "a"
    run.handle(BudgetExceeded("z", "report"), 0.0)
    assert run.causes() == [cause, "z is over its budget"]


def test_a_run_that_ended_by_itself_has_no_reason():
    run = ShutdownMachine([])
    run.handle(ShutdownDecided("idle"), 0.0)
    assert run.end_reason == ""


# ---- other hosts


def test_a_host_that_failed_makes_the_exit_code_1_whatever_ended_the_run():
    run = ShutdownMachine([running()])
    run.handle(Interrupted(INT), 0.0)
    run.handle(HostFailed("could not be reached: bot1"), 1.0)
    run.handle(ProcessEnded("a", DIED, report="a"), 1.0)
    assert run.exit_code() is ExitCode.PROCESS_FAILED
    assert run.causes()[-1] == "could not be reached: bot1"


def test_the_end_does_not_wait_for_abandoned_processes():
    one = running()
    run = ShutdownMachine([one])
    run.handle(ShutdownDecided("reason"), 0.0)
    assert run.handle(IDLE, 0.0) == []
    one.is_abandoned = True
    assert run.handle(IDLE, 0.0) == [EndLeftovers(0)]


@pytest.mark.parametrize("signum", [None, INT, TERM])
def test_a_crash_in_answer_to_the_stop_is_a_failure(signum: int | None):
    run = ShutdownMachine([running()], exit_when_any_dies=True)
    if signum is not None:
        run.handle(Interrupted(signum), 0.0)
    end = ReportExit(Outcome(returncode=-11), asked=False, retry_in_s=None, crashed=True)
    run.handle(ProcessEnded("robot-1", end, is_required=True, report="why"), 1.0)
    codes = {INT: ExitCode.INTERRUPTED, TERM: ExitCode.TERMINATED}
    assert run.exit_code() is codes.get(signum or 0, ExitCode.PROCESS_FAILED)
    assert run.causes() == ["robot-1 ended unexpectedly (SIGSEGV)"]
    assert run.first_failure == "why"
    assert run.is_stopping is (signum is not None), "a user who stops it does not end the run"
    assert signum is not None or run.handle(Occurrence.TICK, 1.0) == []
