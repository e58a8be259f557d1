"""A unit of systemd whose journal, shell and operator tell their parts in any order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy, StopPolicy
from launcher.hosts.engine.systemd.host_facts import HostFacts
from launcher.hosts.engine.systemd.scripts import Scripts
from launcher.hosts.engine.systemd.shell import ScriptRequest, ScriptResult
from launcher.hosts.engine.systemd.unit_check import SUSPICIOUS
from launcher.hosts.engine.systemd.unit_process import UnitProcess
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.file.order import Order
from launcher.posix.reactor import Reactor
from launcher.run.processes.machine_events import (
    Exited,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
)
from tests.support.waiting import wait_until

FACTS = HostFacts(
    uid=0,
    user="root",
    home="/root",
    runtime="/run",
    version=252,
    state="running",
    lingers=False,
    boot_id="b",
    uptime_s=1.0,
    cursor=None,
    has_launcher=True,
    python="python3",
)
FAILED = Outcome(returncode=1)


class There:
    """The host, as far as the process asks it for something."""

    def __init__(self, reactor: Reactor) -> None:
        self.reactor = reactor
        self.requests: deque[ScriptRequest] = deque()
        self.events: list[MachineEvent] = []
        self.marks: list[Callable[[], None]] | None = None  # of a journal that is behind
        scripts = Scripts("k3", Host(name="bot1", address="10.0.0.1"), FACTS)
        restart = RestartPolicy(mode=RestartMode.ALWAYS, delay_s=60.0)
        order = Order(name="a-1", label="a", words=(("a",),), environment={}, restart=restart)
        self.process = UnitProcess(
            1,
            order,
            lambda: scripts,
            reactor,
            self.requests.append,
            lambda number, event, at_s, pid, left_s: self.events.append(event),
            self.mark,
            lambda text: None,
        )

    def mark(self, callback: Callable[[], None]) -> None:
        if self.marks is None:
            callback()
        else:
            self.marks.append(callback)

    @property
    def state(self) -> ProcessState:
        return self.process.machine.state

    def answer(self, text: str = "", code: int = 0) -> None:
        request = self.requests.popleft()
        if request.on_answer is not None:
            request.on_answer(ScriptResult(code, text))

    def begin(self) -> None:
        """A start from here, whose answer comes."""
        self.process.command(MachineCommand.START)
        self.answer("InvocationID=i1\nExecMainPID=7\nActiveState=active\nNRestarts=0")
        assert self.state is ProcessState.RUNNING

    def exit(self, invocation: str, outcome: Outcome = FAILED) -> None:
        """The journal tells an exit, and what it waits for is over."""
        self.process.noted_exit(invocation, outcome, self.reactor.now())
        self.await_exit()

    def await_exit(self) -> None:
        def is_handled() -> bool:
            self.reactor.turn()
            return isinstance(self.events[-1], Exited)

        wait_until(is_handled, "its exit")

    def asked(self) -> list[str]:
        """The verbs of systemctl in the requests that are not answered."""
        return [request.script.split()[1] for request in self.requests]


@pytest.fixture
def there() -> Iterator[There]:
    with Reactor() as reactor:
        made = There(reactor)
        yield made
        made.process.close()


STOPS = [MachineCommand.STOP, MachineCommand.USER_STOP]


@pytest.mark.parametrize("stop", STOPS)
def test_systemd_is_told_not_to_restart_what_is_stopped(there: There, stop: MachineCommand):
    there.begin()
    there.exit("i1")
    assert there.state is ProcessState.BACKOFF
    there.process.command(stop)

    assert there.state is ProcessState.STOPPED
    assert there.asked() == ["stop"]


@pytest.mark.parametrize("stop", STOPS)
@pytest.mark.parametrize("is_answered", [False, True])
def test_a_restart_that_was_faster_than_the_stop_is_stopped(
    there: There, stop: MachineCommand, is_answered: bool
):
    there.begin()
    there.exit("i1")
    there.process.command(stop)
    restarted_s = there.reactor.now()
    if is_answered:
        there.answer()
    there.process.noted_start("i2", 8, restarted_s)
    assert there.state is ProcessState.STOPPING
    there.exit("i2")

    assert there.state is ProcessState.STOPPED
    assert there.process.machine.is_held is (stop is MachineCommand.USER_STOP)
    assert there.asked() == ([] if is_answered else ["stop"])


@pytest.mark.parametrize("stop", STOPS)
def test_a_restart_in_progress_is_stopped(there: There, stop: MachineCommand):
    there.begin()
    there.exit("i1")
    there.process.noted_restart(there.reactor.now())
    assert there.state is ProcessState.STARTING
    there.process.command(stop)

    assert there.state is ProcessState.STOPPED
    assert there.asked() == ["stop"]


def test_a_start_in_progress_is_stopped_and_not_only_signalled(there: There):
    there.process.command(MachineCommand.START)
    there.process.command(MachineCommand.STOP)
    there.answer("InvocationID=i1\nExecMainPID=7\nActiveState=active\nNRestarts=0")

    assert there.state is ProcessState.STOPPING
    assert there.asked() == ["stop"]  # after a signal, systemd would restart it


def test_an_exit_whose_start_is_not_told_belongs_to_the_stop(there: There):
    there.begin()
    there.exit("i1")
    there.process.command(MachineCommand.STOP)
    there.answer()
    there.exit("i2")

    assert there.state is ProcessState.STOPPED


def test_a_stop_there_that_is_told_before_the_start_of_what_it_stops(there: There):
    there.begin()
    there.exit("i1")
    restarted_s = there.reactor.now()
    there.process.noted_stop(there.reactor.now(), by_user=True)
    there.process.noted_start("i2", 8, restarted_s)
    there.exit("i2")

    assert there.state is ProcessState.STOPPED


def test_another_operator_may_start_what_was_stopped(there: There):
    there.begin()
    there.process.command(MachineCommand.USER_STOP)
    there.answer()
    there.exit("i1")
    assert there.state is ProcessState.STOPPED
    there.process.noted_start("i2", 8, there.reactor.now())

    assert there.state is ProcessState.RUNNING
    assert there.asked() == []


def test_signals_of_a_stop_follow_the_request_of_the_stop(there: There):
    there.begin()
    for _ in range(3):
        there.process.command(MachineCommand.SKIP_GRACE)

    assert there.asked() == ["stop", "kill", "kill"]


@pytest.mark.parametrize(
    ("found", "state"),
    [
        ({"ActiveState": "inactive", "Result": "exit-code"}, ProcessState.STOPPED),
        ({"ActiveState": "inactive"}, ProcessState.STOPPED),  # and forgotten
        ({"ActiveState": "failed", "Result": "start-limit-hit"}, ProcessState.FATAL),
        ({"ActiveState": "activating", "SubState": "auto-restart"}, ProcessState.BACKOFF),
    ],
)
def test_what_does_not_wait_any_more_for_its_restart(
    there: There, found: dict[str, str], state: ProcessState
):
    there.begin()
    there.exit("i1")
    for _ in range(SUSPICIOUS):
        there.process.seen(found, there.reactor.now())

    assert there.state is state
    assert there.asked() == []


FORGOTTEN = {"ActiveState": "inactive", "ExecMainCode": "0"}


def test_a_stop_that_is_told_after_its_end_is_not_escalated(there: There):
    """The link was lost, and the watch has stopped the process."""
    there.process.machine.stop = StopPolicy(0.01, 60.0)
    there.begin()
    there.process.suspend_timers()
    there.process.noted_stop(there.reactor.now(), by_user=False)
    until_s = there.reactor.now() + 0.1
    while there.reactor.now() < until_s:
        there.reactor.turn()
    there.process.noted_exit("i1", Outcome(returncode=-2), there.reactor.now())
    there.process.resume_timers()  # before it is handled
    there.await_exit()

    assert there.asked() == []
    assert MachineCommand.TICK not in there.events


@pytest.mark.parametrize(
    ("state", "escalates"),
    [
        ("ActiveState=deactivating\nInvocationID=i1\nMainPID=7", True),
        ("ActiveState=inactive\nInvocationID=\nMainPID=0", False),
        ("ActiveState=failed\nInvocationID=i1\nMainPID=0", False),
        ("ActiveState=activating\nSubState=auto-restart\nInvocationID=i1", False),
    ],
)
def test_only_what_still_runs_there_is_escalated(there: There, state: str, escalates: bool):
    """The exit may be behind much output in the journal."""
    there.process.machine.stop = StopPolicy(0.01, 60.0)
    there.begin()
    there.process.command(MachineCommand.STOP)
    assert there.asked() == ["stop"]
    there.answer()

    def is_asked() -> bool:
        there.reactor.turn()
        return bool(there.requests)

    wait_until(is_asked, "the look before SIGTERM")
    assert there.asked() == ["show"]
    there.answer(state)
    assert there.asked() == ["kill"] * escalates
    assert (MachineCommand.TICK in there.events) == escalates


def test_an_exit_that_the_journal_tells_late_is_not_guessed(there: There):
    """Behind much output; systemd has forgotten the unit, and its exit code."""
    there.begin()
    there.marks = []
    for _ in range(3 * SUSPICIOUS):
        there.process.seen(FORGOTTEN, there.reactor.now())
    assert there.state is ProcessState.RUNNING

    there.exit("i1", Outcome(returncode=0))
    assert there.events[-1] == Exited(Outcome(returncode=0))


def test_an_exit_that_the_journal_does_not_tell_is_known_from_the_unit(there: There):
    there.begin()
    there.marks = []
    for _ in range(SUSPICIOUS):
        there.process.seen(FORGOTTEN, there.reactor.now())
    (mark,) = there.marks
    mark()
    there.process.seen(FORGOTTEN, there.reactor.now())
    there.await_exit()

    assert there.events[-1] == Exited(Outcome(returncode=-9))


def test_an_unknown_end_of_a_unit_that_is_stopped_is_that_of_the_stop(there: There):
    there.begin()
    there.process.command(MachineCommand.STOP)
    there.answer()
    for _ in range(SUSPICIOUS + 1):
        there.process.seen(FORGOTTEN, there.reactor.now())
    there.await_exit()
    assert there.events[-1] == Exited(Outcome(returncode=-2))


@pytest.mark.parametrize("timed_out", [True, False])
def test_a_sigkill_of_systemd_at_the_end_of_its_patience_is_a_step_of_the_stop(
    there: There, timed_out: bool
):
    ends: list[ReportExit] = []
    there.begin()
    there.process._ended = ends.append  # type: ignore[method-assign]
    there.process.command(MachineCommand.STOP)
    there.process.noted_exit("i1", Outcome(returncode=-9), there.reactor.now(), timed_out=timed_out)
    there.await_exit()
    assert there.process.machine.had_to_be_killed is timed_out
    assert [end.crashed for end in ends] == [not timed_out]
    assert there.asked() == ["stop"], "nothing is sent from here"


def test_a_mark_of_a_doubt_that_is_over_settles_no_other(there: There):
    there.begin()
    there.marks = []
    for _ in range(SUSPICIOUS):
        there.process.seen(FORGOTTEN, there.reactor.now())
    running = {"ActiveState": "active", "MainPID": "7", "InvocationID": "i1"}
    there.process.seen(running, there.reactor.now())
    there.marks.pop()()
    for _ in range(3 * SUSPICIOUS):
        there.process.seen(FORGOTTEN, there.reactor.now())

    assert there.state is ProcessState.RUNNING
