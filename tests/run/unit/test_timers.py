"""Timers of the launch file: from when they count, with a clock and a spawner of the test."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator

import pytest

from launcher.base.model.events import CallLater, Outcome
from launcher.base.model.spec import ProcessSpec
from launcher.run.launch_timers import LaunchTimers
from launcher.run.processes.machine_events import Exited, MachineCommand
from launcher.run.processes.process import Process

STEP_S = 0.125  # exact in a float, as its multiples


class Clock:
    """The reactor's timers, in a time that only passes when the test says so."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.heap: list[tuple[float, int, list[Callable[[], object] | None]]] = []

    def now(self) -> float:
        return self.now_s

    def call_at(self, when_s: float, callback: Callable[[], object]) -> Call:
        call = Call(when_s, callback)
        heapq.heappush(self.heap, (when_s, len(self.heap), call.box))
        return call

    def advance(self, seconds: float) -> None:
        self.now_s += seconds
        while self.heap and self.heap[0][0] <= self.now_s:
            (callback,) = heapq.heappop(self.heap)[2]
            if callback is not None:
                callback()


class Call:
    def __init__(self, when: float, callback: Callable[[], object]) -> None:
        self.when = when
        self.box: list[Callable[[], object] | None] = [callback]

    def cancel(self) -> None:
        self.box[0] = None


class Cancellable:
    def __init__(self, cancel: Callable[[], object]) -> None:
        self.cancel = cancel


class Simulation:
    """The ROS clock: notes what it is asked for."""

    def __init__(self) -> None:
        self.delays: dict[int, float] = {}

    def call_later(self, timer_id: int, delay_s: float) -> Cancellable:
        self.delays[timer_id] = delay_s
        return Cancellable(lambda: self.delays.pop(timer_id))


class World:
    """`warm` are processes that wait for a preparation while that `is_preparing`."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.simulation: Simulation | None = None
        self.is_preparing = False
        self.warm: set[Process] = set()
        self.fired: list[int] = []
        self.timers = LaunchTimers(
            self.clock,  # type: ignore[arg-type]
            self,
            self.fired.append,
            lambda: self.simulation,  # type: ignore[arg-type, return-value]
        )

    def is_under_way(self, process: Process) -> bool:
        return process in self.warm

    def awaits_preparation(self, process: Process) -> bool:
        return self.is_preparing and process in self.warm

    def process(self, *, is_warm: bool = False) -> Process:
        """One that is started now, at once or warm."""
        spec = ProcessSpec(name="a-1", label="a", argv=("a",), env={})
        process = Process(1, spec, number=0, prefix=b"")
        process.machine.handle(MachineCommand.START, self.clock.now_s)
        if is_warm:
            self.warm.add(process)
        else:
            process.machine.handle(MachineCommand.STARTED, self.clock.now_s)
        return process

    def starts(self, process: Process) -> None:
        """A warm one runs."""
        self.warm.discard(process)
        process.machine.handle(MachineCommand.STARTED, self.clock.now_s)
        self.timers.settled(process)

    def fails(self, process: Process) -> None:
        self.warm.discard(process)
        process.machine.handle(MachineCommand.START_CANCELLED, self.clock.now_s)
        self.timers.settled(process)

    def moment(self, *effects: Process | CallLater) -> None:
        """What the launch file asks for at once, each taking a step."""
        self.clock.advance(STEP_S * len(effects))
        timers = [one for one in effects if isinstance(one, CallLater)]
        self.timers.add(timers, [one for one in effects if isinstance(one, Process)])

    def fires_after(self, timer_id: int) -> float:
        """Seconds from now."""
        begin_s = self.clock.now_s
        for _ in range(1000):
            if timer_id in self.fired:
                return self.clock.now_s - begin_s
            self.clock.advance(STEP_S)
        pytest.fail(f"timer {timer_id} never fires")


@pytest.fixture
def world() -> Iterator[World]:
    yield World()


def after(timer_id: int, delay_s: float, **options: bool) -> CallLater:
    return CallLater(timer_id, delay_s, **options)


def test_without_processes_it_counts_from_its_moment(world: World):
    world.moment(after(1, 5.0))
    assert world.fires_after(1) == 5.0


def test_it_counts_from_the_first_process_of_its_moment_wherever_it_stands(world: World):
    first = world.process()
    world.moment(first, after(1, 5.0))
    assert world.fires_after(1) == 5.0 - 2 * STEP_S
    world.moment(after(2, 5.0), world.process())
    assert world.fires_after(2) == 5.0 - 2 * STEP_S


def test_it_counts_from_the_first_warm_start_after_the_preparation(world: World):
    world.is_preparing = True
    cold, *warm = world.process(), world.process(is_warm=True), world.process(is_warm=True)
    world.moment(cold, *warm, after(1, 5.0))
    world.clock.advance(7.0)
    world.is_preparing = False
    world.starts(warm[1])
    world.clock.advance(0.5)
    world.starts(warm[0])
    assert world.fires_after(1) == 4.5


def test_one_that_is_found_to_be_no_warm_start_does_not_end_the_wait(world: World):
    world.is_preparing = True
    odd, warm = world.process(is_warm=True), world.process(is_warm=True)
    world.moment(odd, warm, after(1, 5.0))
    world.starts(odd)
    world.clock.advance(6.0)
    assert world.fired == []
    world.is_preparing = False
    world.starts(warm)
    assert world.fires_after(1) == 5.0


def test_if_no_start_succeeds_it_counts_from_the_last_that_was_given_up(world: World):
    one, two = world.process(is_warm=True), world.process(is_warm=True)
    world.moment(one, two, after(1, 5.0))
    world.fails(one)
    world.clock.advance(6.0)
    assert world.fired == []
    world.fails(two)
    assert world.fires_after(1) == 5.0


def test_a_warm_start_of_a_prepared_run_is_waited_for_if_it_is_the_first(world: World):
    warm = world.process(is_warm=True)
    world.moment(warm, after(1, 1.0))
    world.moment(world.process(), world.process(is_warm=True), after(2, 1.0))
    assert world.fires_after(2) == 1.0 - 3 * STEP_S
    assert world.fired == [2]
    world.starts(warm)
    assert world.fires_after(1) == 1.0


def test_timers_of_other_moments_and_steps_of_the_interpreter_do_not_wait(world: World):
    world.is_preparing = True
    world.moment(world.process(is_warm=True), after(1, 0.0), after(2, 0.0, is_step=True))
    world.moment(after(3, 0.0))
    world.clock.advance(STEP_S)
    assert world.fired == [2, 3]


def test_equal_timers_fire_in_their_order(world: World):
    warm = world.process(is_warm=True)
    world.moment(warm, after(3, 0.5), after(1, 0.5), after(2, 0.5))
    world.starts(warm)
    world.clock.advance(0.5)
    assert world.fired == [3, 1, 2]


def test_one_that_waits_can_be_cancelled(world: World):
    warm = world.process(is_warm=True)
    world.moment(warm, after(1, 0.5), after(2, 0.5), after(3, 0.5, outlives_shutdown=True))
    world.timers.cancel(1)
    assert len(world.timers) == 2
    world.timers.cancel_all(outliving=False)
    assert len(world.timers) == 1
    world.fails(warm)
    world.clock.advance(1.0)
    assert world.fired == [3]
    assert len(world.timers) == 0


def test_on_the_clock_of_a_simulation_it_counts_from_the_same_start(world: World):
    warm = world.process(is_warm=True)
    world.moment(warm, after(1, 5.0, on_ros_clock=True), after(2, 5.0))
    world.moment(after(3, 5.0, on_ros_clock=True))
    simulation = world.simulation = Simulation()
    world.timers.move_to(simulation)  # type: ignore[arg-type]
    assert simulation.delays == {3: 5.0}
    world.clock.advance(1.0)
    world.starts(warm)
    assert simulation.delays == {1: 5.0, 3: 5.0}
    assert world.fires_after(2) == 5.0
    world.timers.cancel_all(outliving=True)
    assert simulation.delays == {}


def test_the_time_of_the_run_begins_with_its_first_moment(world: World):
    world.is_preparing = True
    warm = world.process(is_warm=True)
    assert world.timers.elapsed_s == 0.0
    world.moment(warm)
    world.moment()
    world.clock.advance(9.0)
    assert world.timers.elapsed_s == 0.0
    world.is_preparing = False
    world.starts(warm)
    world.clock.advance(2.0)
    world.moment(world.process())
    assert world.timers.elapsed_s == 2.0 + STEP_S


def test_a_start_that_failed_after_an_earlier_life_gives_no_time(world: World):
    process = world.process()
    process.machine.handle(Exited(Outcome(returncode=0)), world.clock.now_s)
    world.clock.advance(100.0)
    process.machine.handle(MachineCommand.START, world.clock.now_s)
    world.warm.add(process)
    world.moment(process, after(1, 5.0))
    world.fails(process)
    assert world.fires_after(1) == 5.0
