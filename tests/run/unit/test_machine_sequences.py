"""Random event sequences of a process: never two children, and every stop ends it."""

from __future__ import annotations

import errno
import signal

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy, StopPolicy
from launcher.run.processes.machine import ProcessMachine
from launcher.run.processes.machine_events import (
    Exited,
    MachineAction,
    MachineCommand,
    MachineEvent,
    ProcessState,
    ReportExit,
    Signal,
    SignalSent,
    SpawnError,
)
from tests.support.examples import examples

KILL = signal.SIGKILL
SEQUENCES = 10_000
STEPS_S = (0.0, 0.01, 0.4, 0.5, 0.7, 1.3, 5.0, 61.0)
POLICIES = [
    RestartPolicy(mode=mode, delay_s=delay_s, max_restarts=most, window_s=window_s)
    for mode in RestartMode
    for delay_s in (0.0, 0.5)
    for most, window_s in ((None, None), (0, None), (2, None), (2, 60.0))
]
STOPS = [
    StopPolicy(),
    StopPolicy(sigterm_timeout_s=0.5, sigkill_timeout_s=0.0),
    StopPolicy(polite=()),
    StopPolicy(polite=((signal.SIGUSR1, 0.4), (signal.SIGINT, 1.3), (signal.SIGTERM, 0.0))),
]


class World:
    """Carries out the actions of the machine, as the process driver does, on a simulated clock.

    A spawn is done at once, waits for its turn (`queued`), or is a child on its way to its
    program (`staged`). A `deaf` child is one that not even SIGKILL ends for now.
    """

    def __init__(self, restart: RestartPolicy, stop: StopPolicy, how: str) -> None:
        self.one = ProcessMachine(restart, stop, chance=lambda: 0.5)
        self.how = how
        self.pending = ""
        self.alive = 0
        self.deaf = False
        self.doomed = False
        self.now = 0.0
        self.asked_to_stop = False

    def feed(self, event: MachineEvent) -> None:
        for action in self.one.handle(event, self.now):
            match action:
                case MachineAction.SPAWN:
                    assert not self.asked_to_stop, "it starts although it was stopped"
                    self.spawn()
                case Signal(signum=signum):
                    is_for_users = signum in (signal.SIGSTOP, signal.SIGCONT)
                    assert self.alive or is_for_users, "a signal to nobody"
                    self.doomed = self.doomed or signum == KILL
                    self.meet_its_doom()
                case ReportExit():
                    assert self.alive == 0, "it is told dead, and lives"
        if self.one.state is ProcessState.STOPPING and self.pending == "queued":
            self.pending = ""
            self.feed(MachineCommand.START_CANCELLED)

    def spawn(self) -> None:
        assert self.alive == 0 and not self.pending, "two live children of one spec"
        if self.how == "at once":
            self.alive = 1
            self.feed(MachineCommand.STARTED)
            return
        self.pending = self.how
        self.alive = int(self.how == "staged")

    def arrive(self) -> None:
        """What a pending spawn waited for has come."""
        if self.pending:
            self.pending = ""
            self.alive = 1
            self.feed(MachineCommand.STARTED)

    def refuse(self) -> None:
        if self.pending:
            self.pending = ""
            self.alive = 0
            self.feed(SpawnError(errno.EAGAIN))

    def hear(self) -> None:
        self.deaf = False
        self.meet_its_doom()

    def meet_its_doom(self) -> None:
        if self.doomed and not self.deaf:
            self.die(-9)

    def die(self, code: int) -> None:
        if self.alive and not self.pending:
            self.alive = 0
            self.doomed = False
            self.feed(Exited(Outcome(returncode=code)))

    def do(self, byte: int) -> None:
        self.now += STEPS_S[byte >> 5]
        command = COMMANDS[byte % len(COMMANDS)]
        match command:
            case MachineCommand.START | MachineCommand.USER_START | MachineCommand.RESTART:
                self.asked_to_stop = False
                self.feed(command)
            case MachineCommand.STOP | MachineCommand.USER_STOP:
                self.feed(command)
                self.asked_to_stop = True
            case int():
                self.die(command)
            case str():
                getattr(self, command)()
            case _:
                self.feed(command)
        assert self.alive == 0 or self.one.state.is_alive, "a child that nobody knows of"

    def become_deaf(self) -> None:
        self.deaf = True

    def stop_for_good(self) -> None:
        self.hear()
        self.asked_to_stop = False
        self.feed(MachineCommand.STOP)
        self.asked_to_stop = True
        for _ in range(8):
            self.arrive()
            self.now += 10.0
            self.feed(MachineCommand.TICK)


# Events as they are; numbers are ends with this return code; words are methods of the world.
COMMANDS: tuple[MachineEvent | int | str, ...] = (
    *(
        one
        for one in MachineCommand
        if one not in (MachineCommand.STARTED, MachineCommand.START_CANCELLED)
    ),
    *(MachineCommand.START, MachineCommand.TICK, MachineCommand.TICK, SignalSent(signal.SIGTERM)),
    *(0, 1, -11, "arrive", "arrive", "refuse", "become_deaf", "hear"),
)


@settings(max_examples=examples(SEQUENCES), suppress_health_check=[HealthCheck.too_slow])
@given(
    st.binary(max_size=48),
    st.sampled_from(POLICIES),
    st.sampled_from(STOPS),
    st.sampled_from(["at once", "queued", "staged"]),
)
def test_there_is_at_most_one_child_and_every_stop_ends_it(
    sequence: bytes, restart: RestartPolicy, stop: StopPolicy, how: str
):
    world = World(restart, stop, how)
    for byte in sequence:
        world.do(byte)
    world.stop_for_good()
    assert world.alive == 0
    assert not world.pending
    assert world.one.state in (ProcessState.STOPPED, ProcessState.EXITED, ProcessState.FATAL)
    assert world.one.deadline is None
