"""The replica of a state machine follows the original over a link that is cut now and then."""

from __future__ import annotations

import errno
import random
import signal
from collections import deque

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy, StopPolicy
from launcher.hosts.engine.replica import STARTS, Replica, ReportingMachine
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    Action,
    Escalate,
    Exited,
    MachineAction,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
    ReportStuck,
    Signal,
    SignalSent,
    SpawnError,
)
from tests.support.examples import examples

OFFSET_S = 12345.678  # of the operator's clock
SEQUENCES = 5_000
STEPS_S = (0.0, 0.013, 0.41, 0.53, 0.77, 1.31, 5.03, 61.7)  # no two sums of these are equal
POLICIES = [
    RestartPolicy(
        mode=mode,
        delay_s=0.5,
        backoff_max_s=backoff_s,
        jitter=0.5,
        max_restarts=most,
        window_s=window_s,
    )
    for mode in RestartMode
    for backoff_s in (None, 20.0)
    for most, window_s in ((None, None), (2, None), (2, 60.0))
]
STOPS = [
    StopPolicy(),
    StopPolicy(sigterm_timeout_s=0.5, sigkill_timeout_s=0.0),
    StopPolicy(polite=((signal.SIGUSR1, 0.4), (signal.SIGTERM, 0.0))),
]
REPORTING = (Signal, Escalate, ReportStuck, ReportExit)


class World:
    """A host with one process, an operator, and a link between them with a queue for each way."""

    def __init__(self, restart: RestartPolicy, stop: StopPolicy, seed: int) -> None:
        self.original = ReportingMachine(restart, stop, self.report)
        self.original._chance = random.Random(seed).random
        self.replica = Replica(restart, stop)
        self.now = 100.0  # of the host
        self.is_cut = False
        self.is_alive = False
        self.is_full = False  # the next spawn fails
        self.to_host: deque[MachineCommand | SignalSent] = deque()
        self.to_operator: deque[tuple[MachineEvent, float, float | None]] = deque()
        self.done_there: list[Action] = []
        self.done_here: list[Action] = []

    # ---- the host

    def report(self, event: MachineEvent, now: float, left_s: float | None) -> None:
        self.to_operator.append((event, now, left_s))

    def feed(self, event: MachineEvent) -> None:
        for action in self.original.handle(event, self.now):
            self.done_there.append(action)
            if action is MachineAction.SPAWN and self.is_full:
                self.is_full = False
                self.feed(SpawnError(errno.EAGAIN))
            elif action is MachineAction.SPAWN:
                self.is_alive = True
                self.feed(MachineCommand.STARTED)
            elif action == Signal(signal.SIGKILL):
                self.die(-9)

    def die(self, code: int) -> None:
        if self.is_alive:
            self.is_alive = False
            self.feed(Exited(Outcome(returncode=code)))

    # ---- the operator, and the link

    def ask(self, request: MachineCommand | SignalSent) -> None:
        if request in STARTS:
            self.replica.wants_start()
        self.to_host.append(request)
        self.carry()

    def carry(self) -> None:
        while not self.is_cut and (self.to_host or self.to_operator):
            if self.to_host:
                self.feed(self.to_host.popleft())
            while self.to_operator:
                event, now, left_s = self.to_operator.popleft()
                self.done_here += self.replica.follow(event, now + OFFSET_S, left_s)

    # ---- steps

    def do(self, byte: int) -> None:
        self.now += STEPS_S[byte >> 5]
        match STEPS[byte % len(STEPS)]:
            case "cut":
                self.is_cut = True
            case "restore":
                self.is_cut = False
            case "fill":
                self.is_full = True
            case "tick":
                self.feed(MachineCommand.TICK)
            case "stop there":
                self.feed(MachineCommand.STOP)
            case int(code):
                self.die(code)
            case request:
                self.ask(request)
        self.carry()


STEPS: tuple[MachineCommand | SignalSent | str | int, ...] = (
    MachineCommand.START,
    MachineCommand.START,
    MachineCommand.USER_START,
    MachineCommand.STOP,
    MachineCommand.USER_STOP,
    MachineCommand.RESTART,
    MachineCommand.SKIP_GRACE,
    MachineCommand.SUSPEND,
    MachineCommand.RESUME,
    SignalSent(signal.SIGTERM),
    SignalSent(signal.SIGKILL, by_user=False),
    *("cut", "restore", "tick", "tick", "tick", "stop there", "fill", 0, 1, -11, -15),
)


def facts(machine: ProcessMachine, offset_s: float = 0.0) -> dict[str, object]:
    """All that a decision of the machine, or a message, depends on."""

    def on_host(time_s: float | None) -> object:
        return None if time_s is None else pytest.approx(time_s - offset_s, abs=1e-6)

    return {
        "state": machine.state,
        "restarts": machine.restarts,
        "deadline": on_host(machine.deadline),
        "running_since": on_host(machine.running_since),
        "flags": (machine.is_held, machine.is_suspended, machine.had_to_be_killed),
        "stuck": machine.is_stuck,
        "step": machine._step,
        "sent": {signum: on_host(when_s) for signum, when_s in machine._sent.items()},
        "quick_ends": machine._quick_ends,
        "starts_again": machine._starts_again,
        "recent": [on_host(when_s) for when_s in machine._recent],
    }


def reports(actions: list[Action]) -> list[Action]:
    return [action for action in actions if isinstance(action, REPORTING)]


@settings(max_examples=examples(SEQUENCES), suppress_health_check=[HealthCheck.too_slow])
@given(
    st.binary(max_size=60),
    st.sampled_from(POLICIES),
    st.sampled_from(STOPS),
    st.integers(0, 1000),
)
def test_the_replica_is_as_the_original_when_it_has_caught_up(
    sequence: bytes, restart: RestartPolicy, stop: StopPolicy, seed: int
):
    world = World(restart, stop, seed)
    for byte in sequence:
        world.do(byte)
        if not world.is_cut:
            assert facts(world.original) == facts(world.replica, OFFSET_S)
    world.is_cut = False
    world.carry()
    assert facts(world.original) == facts(world.replica, OFFSET_S)
    assert len(reports(world.done_here)) == len(reports(world.done_there))
    for here, there in zip(reports(world.done_here), reports(world.done_there), strict=True):
        assert _rounded(here) == _rounded(there)


def _rounded(action: Action) -> tuple[object, ...]:
    return tuple(
        round(value, 6) if isinstance(value, float) else value
        for value in (type(action), *(getattr(action, name) for name in action.__match_args__))
    )


# ---- what shows of a request


def replica(mode: RestartMode = RestartMode.NEVER) -> Replica:
    return Replica(RestartPolicy(mode=mode, delay_s=1.0), StopPolicy())


def test_a_start_that_was_requested_shows_as_starting():
    one = replica()
    one.wants_start()
    assert one.state is ProcessState.STARTING
    assert one.is_pending
    one.follow(MachineCommand.START, 1.0, None)
    one.follow(MachineCommand.STARTED, 1.0, None)
    assert one.state is ProcessState.RUNNING
    one.follow(Exited(Outcome(returncode=0)), 2.0, None)
    assert one.state is ProcessState.EXITED


def test_a_start_without_effect_there_is_forgotten():
    one = replica()
    one.follow(MachineCommand.START, 1.0, None)
    one.follow(MachineCommand.STARTED, 1.0, None)
    one.wants_start()
    one.follow(MachineCommand.USER_START, 1.5, None)
    one.follow(Exited(Outcome(returncode=0)), 2.0, None)
    assert one.state is ProcessState.EXITED


def test_a_process_that_was_lost_with_its_host_is_not_restarted():
    for events in ([], [Exited(Outcome(returncode=1))]):
        one = replica(RestartMode.ALWAYS)
        for event in [MachineCommand.START, MachineCommand.STARTED, *events]:
            one.follow(event, 1.0, 1.0 if events and event is events[0] else None)
        outcome = Outcome(returncode=-9, lost_with="bot1")
        assert one.lose(outcome, 2.0) == [ReportExit(outcome, asked=False, retry_in_s=None)]
        assert str(outcome) == "lost with bot1"
        assert not one.is_pending
        assert one.deadline is None


def test_a_process_that_was_being_stopped_is_lost_as_requested():
    one = replica()
    for event in (MachineCommand.START, MachineCommand.STARTED, MachineCommand.STOP):
        one.follow(event, 1.0, 5.0 if event is MachineCommand.STOP else None)
    (end,) = one.lose(Outcome(returncode=-9, lost_with="bot1"), 2.0)
    assert isinstance(end, ReportExit)
    assert end.asked
