"""Sampling of resources beside the output, with a real reactor and real processes."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping

import pytest

from launcher.base.model.spec import ProcessSpec
from launcher.output.logs.run_directory import RunDirectory
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import StartSettings, start
from launcher.run.logs.run_log import RunLog
from launcher.run.monitor import housekeeping as module
from launcher.run.monitor.housekeeping import Housekeeper
from launcher.run.monitor.resources import Sampler
from launcher.run.processes.process import Process

pytestmark = pytest.mark.thorough

MANY = 40


@pytest.fixture
def sleepers() -> Iterator[list[Process]]:
    """Processes that do nothing, each with a session of its own; ends them."""
    processes = []
    for number in range(MANY):
        spec = ProcessSpec(name=f"sleep-{number}", label="sleep", argv=("sleep", "1000"), env={})
        process = Process(number, spec, number=number, prefix=b"")
        process.child = start(spec, StartSettings(os.environ, merge=True))
        processes.append(process)
    yield processes
    for process in processes:
        assert process.child is not None
        process.child.signal_group(signal.SIGKILL)
        process.child.reap()
        process.child.close()


def test_a_round_of_samples_takes_no_more_than_one_process_at_a_time(sleepers: list[Process]):
    pids = [process.child.pid for process in sleepers if process.child is not None]
    steps = Sampler().steps(pids, Reactor.now)
    assert sum(1 for _ in steps) >= MANY


def test_lines_are_carried_while_a_round_of_samples_goes_on(sleepers: list[Process]):
    happened: list[str] = []

    class Processes(list[Process]):
        """Notes when a round of samples begins, or ends, by looking at them."""

        def __iter__(self) -> Iterator[Process]:
            happened.append("round")
            return super().__iter__()

    with _pipe() as (read_end, write_end), Reactor() as reactor:
        screen = StdoutWriter(reactor, write_end, colour=False)
        run_log = RunLog(reactor, screen, RunDirectory(None, lambda text: None))
        housekeeper = Housekeeper(
            reactor,
            run_log,
            "none",
            Processes(sleepers),
        )
        run_log.events.listeners.append(lambda line: reactor.stop())
        os.write(write_end, b"a line that always waits\n")
        reactor.add_reader(read_end, lambda: happened.append("line"))
        housekeeper.start()
        reactor.run()
        housekeeper.close()
        screen.finish()
    assert len(housekeeper.samples) == MANY
    # Taken in one go, there are two: one before the round is noted, one before that is written.
    assert happened[happened.index("round") :].count("line") > 4


def test_many_processes_are_sampled_less_often(
    sleepers: list[Process], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(module, "PROCESSES_PER_S", MANY // 3)
    begun_s: list[float] = []
    steps = Sampler.steps

    def noted(
        sampler: Sampler, pids: Iterable[int], clock: Callable[[], float], guests: Mapping[int, int]
    ) -> object:
        begun_s.append(clock())
        if len(begun_s) == 2:
            reactor.stop()
        return steps(sampler, pids, clock, guests)

    monkeypatch.setattr(Sampler, "steps", noted)
    with _pipe() as (_, write_end), Reactor() as reactor:
        screen = StdoutWriter(reactor, write_end, colour=False)
        run_log = RunLog(reactor, screen, RunDirectory(None, lambda text: None))
        housekeeper = Housekeeper(reactor, run_log, "none", sleepers)
        assert housekeeper.sample_period_s == 4.0  # 40 processes, 13 a second
        housekeeper.start()
        reactor.run()
        housekeeper.close()
        screen.finish()
    assert begun_s[1] - begun_s[0] >= 3.5


@contextlib.contextmanager
def _pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    yield ends
    for fd in ends:
        os.close(fd)
