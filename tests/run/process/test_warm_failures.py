"""The preparing process: what it costs, and what happens when it, or a start, fails."""

from __future__ import annotations

import errno
import functools
import os
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from launcher.base.model.record import replace
from launcher.base.model.spec import Limits, ProcessSpec
from launcher.posix import spawn
from launcher.posix.cleanup import subreaper
from launcher.posix.limits import parse_refusal
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import Child, StartSettings
from launcher.run.processes.process import Process
from launcher.run.warm import preparing_process, spawner
from launcher.run.warm.spawner import WarmSpawner
from tests.support.children import children, is_alive

MANY = 500
SETTLING = 50  # starts after which the memory of the preparing process stays the same
TIMEOUT_S = 60.0


class Bed:
    """A spawner with a real preparing process; it notes what becomes of each start.

    `ended` has the return code of each process that was forked, `cold` those that were not.
    """

    def __init__(self, folder: Path) -> None:
        self.reactor = Reactor()
        self.cold: list[str] = []
        self.warnings: list[str] = []
        self.ended: dict[str, int] = {}
        self.refusals: dict[str, bytes] = {}
        self.pids: dict[str, int] = {}
        self.folder = folder
        self.spawner = self.make(WarmSpawner)

    def make(self, kind: type[WarmSpawner]) -> WarmSpawner:
        spawner = kind(
            self.reactor,
            self,
            settings_of=lambda process, spec: StartSettings(spec.env, merge=True),
            warn=self.warnings.append,
            is_forced=True,
            is_interactive=False,
        )
        spawner.settle()
        return spawner

    def process(self, text: str, name: str = "a") -> Process:
        script = self.folder / f"{name}.py"
        script.write_text(text)
        argv = (sys.executable, str(script))
        spec = ProcessSpec(name=name, label=name, argv=argv, env=dict(os.environ))
        return Process(0, spec, number=0, prefix=b"")

    def start(self, text: str, name: str = "a") -> Process:
        process = self.process(text, name)
        if not self.spawner.admit(process):
            self.spawn(process)
        return process

    def run(self, fact: Callable[[], object]) -> None:
        """Run the reactor until this holds."""
        deadline = self.reactor.now() + TIMEOUT_S
        while not fact():
            assert self.reactor.now() < deadline
            self.reactor.call_later(0.05, lambda: None)
            self.reactor._turn(self.reactor.timeout_s())

    def prepare(self) -> int:
        """Start a process, and wait for its end; the pid of the preparing process."""
        self.start("", "first")
        self.run(lambda: "first" in self.ended)
        return self.pid

    @property
    def pid(self) -> int:
        (pid,) = self.spawner.pids
        return pid

    # ---- the driver

    def spawn(self, process: Process) -> None:
        self.cold.append(process.name)

    def adopt(self, process: Process, child: Child) -> None:
        self.pids[process.name] = child.pid
        self.reactor.add_reader(child.pidfd, functools.partial(self._exited, process.name, child))

    def _exited(self, name: str, child: Child) -> None:
        self.reactor.remove(child.pidfd)
        child.read_refusal()
        self.refusals[name] = child.refusal
        self.ended[name] = child.reap()[0]
        child.close()

    def close(self) -> None:
        self.spawner.close()
        self.reactor.close()


@pytest.fixture
def bed(tmp_path: Path) -> Iterator[Bed]:
    assert subreaper.become()
    one = Bed(tmp_path)
    yield one
    one.close()
    subreaper.adopted()  # reaps
    subreaper.resign()


def descriptors(pid: int) -> int:
    return psutil.Process(pid).num_fds()


def uss_bytes(pid: int) -> int:
    return psutil.Process(pid).memory_full_info().uss


@pytest.mark.thorough
def test_many_starts_leak_nothing(bed: Bed):
    bed.prepare()
    ours, theirs, memory = descriptors(os.getpid()), descriptors(bed.pid), 0
    for number in range(MANY):
        if number == SETTLING:
            memory = uss_bytes(bed.pid)
        bed.start("x = 1", "many")
        bed.run(lambda: "many" in bed.ended)
        assert bed.ended.pop("many") == 0
    grown = uss_bytes(bed.pid) - memory
    assert memory > 0
    assert grown < 256 * 1024  # a page for every seventh start would be more
    assert (descriptors(os.getpid()), descriptors(bed.pid)) == (ours, theirs)
    assert bed.cold == bed.warnings == []


def test_without_a_preparing_process_nodes_are_started_cold(
    bed: Bed, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(spawner, "SETTLED_S", 0.0)
    pid = bed.prepare()
    os.kill(pid, signal.SIGKILL)
    bed.run(lambda: bed.warnings)
    assert bed.warnings == [
        "the preparing process failed, nodes are started cold: it was ended by SIGKILL"
    ]
    assert not bed.spawner.pids
    process = bed.start("", "second")  # it is forced, so there is a new one
    bed.run(lambda: "second" in bed.ended)
    assert process.start_kind == "warm"
    assert bed.pid != pid


def test_a_start_that_waits_is_cold_if_the_preparing_process_is_killed(bed: Bed):
    process = bed.start("", "waits")
    os.kill(bed.pid, signal.SIGKILL)
    bed.run(lambda: bed.cold)
    assert bed.cold == ["waits"]
    assert process.start_kind == "cold, because the preparing process failed"
    assert len(bed.warnings) == 1
    assert not bed.ended


def test_a_preparing_process_that_hangs_is_replaced(bed: Bed, monkeypatch: pytest.MonkeyPatch):
    pid = bed.prepare()
    monkeypatch.setattr(preparing_process, "SILENCE_S", 0.2)
    os.kill(pid, signal.SIGSTOP)
    bed.start("", "waits")
    bed.run(lambda: bed.cold)
    assert bed.warnings == [
        "the preparing process failed, nodes are started cold: it did not answer for 0.2 s"
    ]
    assert not is_alive(pid)


def test_imports_that_fail_are_not_tried_again(bed: Bed, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(preparing_process, "_SCRIPT", "/no/such/script")
    bed.start("", "first")
    bed.run(lambda: bed.cold)
    assert len(bed.warnings) == 1
    process = bed.start("", "second")
    assert process.start_kind == "cold, because the preparing process failed"
    assert bed.cold == ["first", "second"]
    assert len(bed.warnings) == 1


class Deadly(WarmSpawner):
    """Each process is killed before it is told to begin."""

    def _forked(self, start, pid):
        os.kill(pid, signal.SIGKILL)
        super()._forked(start, pid)


def test_a_process_killed_in_the_middle_of_its_start_has_exited(bed: Bed):
    bed.spawner = bed.make(Deadly)
    bed.start(f"open({str(bed.folder / 'began')!r}, 'w')", "victim")
    bed.run(lambda: "victim" in bed.ended)
    assert bed.ended["victim"] == -signal.SIGKILL
    assert not (bed.folder / "began").exists()


@pytest.mark.parametrize("is_prepared", [False, True])
def test_a_start_that_is_withdrawn_never_begins(bed: Bed, is_prepared: bool):
    if is_prepared:
        bed.prepare()
    before = set(children(os.getpid()))
    process = bed.start(f"open({str(bed.folder / 'began')!r}, 'w')", "withdrawn")
    assert bed.spawner.withdraw(process)
    assert not bed.spawner.withdraw(process)
    bed.start("", "later")
    bed.run(lambda: "later" in bed.ended)
    assert not (bed.folder / "began").exists()
    assert "withdrawn" not in (*bed.pids, *bed.cold)
    # It was reaped: what was forked for it ends when it sees that nobody waits.
    bed.run(lambda: not set(children(os.getpid())) - before - {bed.pid})


def spare_for(bed: Bed, process: Process) -> int:
    """The pid of what is forked ahead for it; the spawner has prepared."""
    before = set(children(os.getpid()))
    bed.spawner.expect(process)
    bed.run(lambda: set(children(os.getpid())) - before)
    (pid,) = set(children(os.getpid())) - before
    bed.run(lambda: pid in spawn.started)
    return pid


def test_an_expected_start_takes_the_process_that_was_forked_ahead(bed: Bed):
    bed.prepare()
    leads_session = "import os, sys; sys.exit(os.getsid(0) == os.getpid())"
    process = bed.process(leads_session, "expected")
    spare = spare_for(bed, process)
    bed.spawner.expect(process)  # there is one already
    assert bed.spawner.admit(process)
    bed.run(lambda: "expected" in bed.ended)
    assert (bed.pids["expected"], bed.ended["expected"]) == (spare, 1)
    bed.start("", "next")
    bed.run(lambda: "next" in bed.ended)
    assert bed.cold == bed.warnings == []


def test_without_the_process_that_was_forked_ahead_another_is_forked(bed: Bed):
    bed.prepare()
    process = bed.process("", "expected")
    spare = spare_for(bed, process)
    os.kill(spare, signal.SIGKILL)
    bed.run(lambda: not is_alive(spare))
    assert bed.spawner.admit(process)
    bed.run(lambda: "expected" in bed.ended)
    assert bed.pids["expected"] != spare
    assert bed.cold == bed.warnings == []


@pytest.mark.parametrize("is_killed", [False, True])
def test_what_was_forked_ahead_ends_with_the_preparing_process(bed: Bed, is_killed: bool):
    pid = bed.prepare()
    spare = spare_for(bed, bed.process("", "expected"))
    if is_killed:
        os.kill(pid, signal.SIGKILL)
        bed.run(lambda: bed.warnings)
    else:
        bed.spawner.close()
    assert not {pid, spare} & {*children(os.getpid()), *spawn.started}


def test_a_refused_limit_is_told_as_by_a_cold_start(bed: Bed):
    process = bed.process("", "limited")
    limits = Limits(rlimits=(("nofile", 64, 32),))
    process.spec = replace(process.spec, limits=limits)
    assert bed.spawner.admit(process)
    bed.run(lambda: "limited" in bed.ended)
    assert parse_refusal(bed.refusals["limited"]) == (errno.EPERM, "nofile=64/32")


def test_with_a_full_table_of_descriptors_the_start_is_cold_and_reports_that(bed: Bed):
    bed.prepare()
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    used = max(map(int, os.listdir("/proc/self/fd")))
    gaps = []  # free numbers below, which depend on what the test runner was started with
    while (number := os.open(os.devnull, os.O_RDONLY)) < used:
        gaps.append(number)
    os.close(number)
    resource.setrlimit(resource.RLIMIT_NOFILE, (used + 2, hard))
    try:
        process = bed.start("", "second")
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        for number in gaps:
            os.close(number)
    assert process.start_kind == "cold, because it could not be asked for"
    assert bed.cold == ["second"]
    bed.start("", "third")
    bed.run(lambda: "third" in bed.ended)


def test_a_request_may_be_long(bed: Bed):
    process = bed.process("import os, sys\nsys.exit(len(os.environ['LONG_9']))", "long")
    long = {f"LONG_{number}": 100_000 * "x" for number in range(9)}
    process.spec = replace(process.spec, env={**os.environ, **long, "LONG_9": "x" * 7})
    assert bed.spawner.admit(process)
    bed.run(lambda: "long" in bed.ended)
    assert bed.ended["long"] == 7


def test_after_the_end_nothing_is_prepared(bed: Bed):
    pid = bed.prepare()
    bed.spawner.close()
    assert not is_alive(pid)
    process = bed.start("", "late")
    assert process.start_kind.startswith("cold")
    assert not bed.spawner.pids


def test_the_end_leaves_nothing_that_looks_for_imports(bed: Bed):
    imported = "\n".join(f"import absent_{number}" for number in range(20))
    for number in range(300):
        (bed.folder / f"module_{number}.py").write_text(imported)
    modules = "\n".join(f"import module_{number}" for number in range(300))
    before = set(children(os.getpid()))
    bed.start(modules, "large")
    bed.run(lambda: children(bed.pid))
    bed.spawner.close()
    assert not set(children(os.getpid())) - before


def test_it_finds_the_launcher_that_is_not_installed(tmp_path: Path):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.close()  # it ends at once
    words = [sys.executable, "-S", preparing_process._SCRIPT, str(theirs.fileno())]
    with theirs:
        subprocess.run(words, pass_fds=[theirs.fileno()], cwd=tmp_path, timeout=60, check=True)
