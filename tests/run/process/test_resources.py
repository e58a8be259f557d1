"""Samples of real process trees."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator

import psutil
import pytest

from launcher.hosts.engine.systemd.samples import Samples
from launcher.posix import proc
from launcher.run.monitor import resources
from launcher.run.monitor.resources import NEW_USS_PER_ROUND, USS_AT_S, Sample, Sampler
from tests.support.children import children
from tests.support.waiting import wait_until

MB = 1024**2
Starter = Callable[[str], subprocess.Popen[bytes]]

IDLE = "import signal; signal.pause()"
BUSY = "while True: pass"
TREE = f"import subprocess, sys; subprocess.run([sys.executable, '-S', '-c', {BUSY!r}])"
# Opens no file after its last thread is there, so that a sample with all threads stays true.
HUNGRY = """
import os, signal, threading
memory = bytearray(os.urandom(64) * (50 << 20 >> 6))
files = [open(os.devnull) for _ in range(40)]
for _ in range(6):
    threading.Thread(target=threading.Event().wait, daemon=True).start()
"""
NO_MAIN_THREAD = "import ctypes; ctypes.CDLL(None).syscall(60, 0)"  # only this thread ends
LATE_CHILD = f"""
import signal, subprocess, sys, threading
command = [sys.executable, "-S", "-c", {IDLE!r}]
signal.signal(signal.SIGUSR1, lambda *_: subprocess.Popen(command))
threading.Thread(target=threading.Event().wait, daemon=True).start()
while True:
    signal.pause()
"""


@pytest.fixture
def start() -> Iterator[Starter]:
    """Starts Python code in a session of its own, as the launcher does; ends all of it."""
    children = []

    def starter(code: str) -> subprocess.Popen[bytes]:
        child = subprocess.Popen([sys.executable, "-S", "-c", code], env={}, start_new_session=True)
        children.append(child)
        return child

    yield starter
    for child in children:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)  # a child of it may have outlived it
        child.wait()


class WholeRounds(Sampler):
    """Takes all steps of a round at once."""

    def sample(self, pids: Iterable[int], now: float) -> dict[int, Sample]:
        steps = self.steps(pids, lambda: now)
        while True:
            try:
                time.sleep(next(steps))
            except StopIteration as end:
                return end.value


def sample_until(sampler: WholeRounds, pid: int, fact: Callable[[Sample], object]) -> Sample:
    """Sample as the supervisor does, only faster, until the fact holds."""
    latest: list[Sample] = []

    def look() -> bool:
        samples = sampler.sample([pid], time.monotonic())
        latest[:] = samples.values()
        return bool(latest and fact(latest[0]))

    wait_until(look, f"a sample that fits; the last one: {latest}")
    return latest[0]


def started_hungry(start: Starter, then: str = IDLE) -> int:
    """The pid of a process that has taken all that it takes."""
    pid = start(HUNGRY + then).pid
    sample_until(WholeRounds(), pid, lambda s: s.threads == 7)
    return pid


@pytest.mark.parametrize("then", [IDLE, NO_MAIN_THREAD], ids=["", "no main thread"])
def test_memory_threads_and_files_of_a_process_are_counted(start: Starter, then: str):
    pid = started_hungry(start, then)
    sample = WholeRounds().sample([pid], time.monotonic())[pid]
    assert sample.threads == 7 and sample.fds >= 43
    assert sample.processes == 1
    assert 50 * MB < sample.rss_bytes < 120 * MB
    assert sample.uss_bytes is None  # not before it has had time to load what it needs


@pytest.mark.parametrize("then", [IDLE, NO_MAIN_THREAD], ids=["", "no main thread"])
def test_a_shell_reads_the_same(start: Starter, then: str):
    """What is read of a unit on another host, here of a process without one."""
    pid = started_hungry(start, then)
    script = Samples().script([pid, 2**22 + 1], 0.0)  # there is no such process
    shell = subprocess.run(["sh", "-c", script], capture_output=True, text=True, check=False)
    (found,) = Samples().read(shell.stdout, {1: pid, 2: 2**22 + 1}, 0.0).values()

    sampler = WholeRounds()
    sampler.sample([pid], time.monotonic())
    expected = sampler.sample([pid], time.monotonic() + 60)[pid]
    assert shell.stderr == ""
    for name in ("rss_bytes", "uss_bytes"):
        assert found.pop(name) == pytest.approx(getattr(expected, name), rel=0.05)
    assert found == {
        "pid": pid,
        "cpu_percent": None,
        "threads": 7,
        "fds": expected.fds,
        "processes": 1,
    }


def test_the_uss_is_read_again_when_it_is_due(start: Starter):
    sampler, child = WholeRounds(), start(HUNGRY + IDLE)
    sample_until(sampler, child.pid, lambda s: s.threads == 7)
    assert sampler.sample([child.pid], time.monotonic() + 2)[child.pid].uss_bytes is not None
    later = sampler.sample([child.pid], time.monotonic() + 60)[child.pid]
    assert later.uss_bytes is not None and 50 * MB < later.uss_bytes <= later.rss_bytes


def test_the_load_of_a_grandchild_counts(start: Starter):
    sampler, child = WholeRounds(), start(TREE)
    sample_until(sampler, child.pid, lambda s: s.processes == 2)
    (grandchild,) = psutil.Process(child.pid).children()

    def used_s() -> float:
        return sum(grandchild.cpu_times()[:2])

    least, begun_s = used_s(), time.monotonic()
    sampler.sample([child.pid], begun_s)
    most = used_s()
    wait_until(lambda: used_s() > most + 1.0, "a second of work")
    between = used_s(), time.monotonic()
    sample = sampler.sample([child.pid], between[1])[child.pid]
    used = (sample.cpu_percent or 0) / 100 * (between[1] - begun_s)
    # The kernel counts in hundredths of a second, for each of the processes.
    assert between[0] - most - 0.05 <= used <= used_s() - least + 0.05


def test_an_idle_process_uses_nothing_and_the_first_sample_knows_no_load(start: Starter):
    sampler, child = WholeRounds(), start(IDLE)
    assert sampler.sample([child.pid], 0.0)[child.pid].cpu_percent is None
    sample_until(sampler, child.pid, lambda s: s.cpu_percent == 0.0)


def test_a_tree_lives_as_long_as_its_root(start: Starter):
    sampler, child = WholeRounds(), start(TREE)
    sample_until(sampler, child.pid, lambda s: s.processes == 2)
    child.kill()
    child.wait()
    assert sampler.sample([child.pid], time.monotonic()) == {}


def test_the_uss_of_many_is_read_a_few_at_a_time(start: Starter):
    pids = [start(IDLE).pid for _ in range(NEW_USS_PER_ROUND + 1)]
    sampler = WholeRounds()
    known = [
        sum(sample.uss_bytes is not None for sample in sampler.sample(pids, now).values())
        for now in (0.0, 0.5, 1.0, 2.0)
    ]
    assert known == [0, 0, NEW_USS_PER_ROUND, NEW_USS_PER_ROUND + 1]


def test_a_new_child_does_not_hide_the_known_uss(start: Starter):
    sampler, child, begun_s = WholeRounds(), start(LATE_CHILD), time.monotonic()
    sample_until(sampler, child.pid, lambda s: s.threads == 2)
    alone = sampler.sample([child.pid], time.monotonic() + 2)[child.pid]
    assert alone.uss_bytes is not None
    os.kill(child.pid, signal.SIGUSR1)
    with_child = sample_until(sampler, child.pid, lambda s: s.processes == 2)
    assert with_child.uss_bytes is not None  # nothing is hidden
    if time.monotonic() < begun_s + USS_AT_S[1]:
        assert with_child.uss_bytes == alone.uss_bytes  # not walked yet
    later = sampler.sample([child.pid], time.monotonic() + 60)[child.pid]
    assert later.uss_bytes is not None and later.uss_bytes > alone.uss_bytes


def test_the_values_are_those_of_psutil(start: Starter):
    pid = started_hungry(start)
    sampler, process = WholeRounds(), psutil.Process(pid)
    sampler.sample([pid], 0.0)
    sample = sampler.sample([pid], 60.0)[pid]
    assert (sample.threads, sample.fds) == (process.num_threads(), process.num_fds())
    assert sample.rss_bytes == pytest.approx(process.memory_info().rss, rel=0.02)
    assert sample.uss_bytes == pytest.approx(process.memory_full_info().uss, rel=0.02)


def test_open_files_are_counted_where_the_kernel_does_not(
    start: Starter, monkeypatch: pytest.MonkeyPatch
):
    pid = started_hungry(start)
    counted = WholeRounds().sample([pid], 0.0)[pid].fds
    monkeypatch.setattr(resources, "_counts_files", lambda: False)
    assert WholeRounds().sample([pid], 0.0)[pid].fds == counted


def test_a_pid_that_was_reused_is_another_process(start: Starter, monkeypatch: pytest.MonkeyPatch):
    sampler, pid = WholeRounds(), start(IDLE).pid
    sampler.sample([pid], 0.0)
    assert sampler.sample([pid], 2.0)[pid].uss_bytes is not None
    fields = proc.stat_fields(pid)
    fields[proc.START_TICKS] += b"1"
    monkeypatch.setattr(proc, "stat_fields", lambda pid: fields)
    assert sampler.sample([pid], 3.0)[pid].uss_bytes == 0  # that of the other is not its own


def test_a_process_that_leads_no_session_has_no_sample(start: Starter):
    sampler, child = WholeRounds(), start(TREE)
    sample_until(sampler, child.pid, lambda s: s.processes == 2)
    (grandchild,) = children(child.pid)
    assert sampler.sample([grandchild], time.monotonic()) == {}


def test_the_most_expensive_value_is_read_in_few_samples(
    start: Starter, monkeypatch: pytest.MonkeyPatch
):
    """The cost itself is compared with that of psutil by `python -m benchmarks sampling`."""
    reads: list[int] = []
    read = proc.uss_bytes

    def counted(pid: int) -> int | None:
        reads.append(pid)
        return read(pid)

    monkeypatch.setattr(proc, "uss_bytes", counted)
    pids = [start(IDLE).pid for _ in range(20)]
    sampler = WholeRounds()
    for second in range(60):
        assert len(sampler.sample(pids, float(second))) == 20
    # At most at both times of a new process, and in each ten seconds.
    assert len(pids) <= len(reads) <= 8 * len(pids)
