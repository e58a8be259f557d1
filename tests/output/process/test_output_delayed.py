"""Lines stay whole and in order when the launcher is delayed or suspended."""

from __future__ import annotations

import os
import re
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from launcher.base.model.spec import OutputPolicy, ProcessSpec
from launcher.output.logs.run_directory import RunDirectory
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import BOTH, Child
from launcher.run.output.output_reader import PARTIAL_LINE_S, OutputReader
from launcher.run.processes.process import Process
from tests.support.benches import Bench
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

# ---- the relay alone, with pipes whose other ends are ours


class ReaderBench:
    """A relay that listens to `a` and `b`, and shows in a file what they write."""

    def __init__(self, folder: Path, reactor: Reactor) -> None:
        self.reactor = reactor
        self._path = folder / "screen"
        self._fds = [os.open(self._path, os.O_WRONLY | os.O_CREAT)]
        self.relay = OutputReader(
            reactor,
            StdoutWriter(reactor, self._fds[0], colour=False),
            RunDirectory(None, lambda text: None),
            (),
            self,
        )
        self.process_of: dict[int, Process] = {}
        self.a, self.b = self._process("a"), self._process("b")
        self.remote = self._spec("remote")

    def watches(self, process: Process) -> bool:
        return False

    def output(self, process: Process, stream: str, data: bytes) -> None:
        raise AssertionError("it is not watched")

    def _process(self, name: str) -> int:
        """The end that it writes to."""
        read_end, write_end = self._pipe()
        os.set_blocking(read_end, False)
        process = self._spec(name)
        process.child = Child(-1, {read_end: BOTH}, -1, -1, -1)
        self.relay.attach(process)
        self.process_of[write_end] = process
        return write_end

    def _spec(self, name: str) -> Process:
        policy = OutputPolicy.named("screen")
        spec = ProcessSpec(name=name, label=name, argv=(name,), env={}, output=policy)
        return Process(0, spec, number=0, prefix=f"[{name}] ".encode())

    def feed(self, chunk: bytes) -> None:
        """What a process on another host has written a while ago."""
        self.relay.feed(self.remote, BOTH, chunk, self.reactor.now() - 60)

    def _pipe(self) -> tuple[int, int]:
        ends = os.pipe()
        self._fds += ends
        return ends

    def end(self, write_end: int) -> None:
        """Close it, and run until that is noticed."""
        streams = self.process_of[write_end].streams
        (read_end,) = streams
        os.close(write_end)
        self._run_until(lambda: not streams)
        self._fds = [fd for fd in self._fds if fd not in (write_end, read_end)]

    def close(self) -> None:
        for fd in self._fds:
            os.close(fd)

    def delay(self, meanwhile: Callable[[], object]) -> None:
        """Block the loop, after its poll for lines, until all timers are overdue."""
        read_end, write_end = self._pipe()

        def hang() -> None:
            self.reactor.remove(read_end)
            overdue_s = self.reactor.now() + 2 * PARTIAL_LINE_S
            wait_until(lambda: self.reactor.now() > overdue_s, "overdue timers")
            meanwhile()

        self.reactor.add_reader(read_end, hang)
        os.write(write_end, b"now")

    def shown(self, end: bytes) -> list[bytes]:
        """Run until this is shown; all that was."""
        self._run_until(lambda: end in self._path.read_bytes())
        return self._path.read_bytes().splitlines()

    def _run_until(self, is_so: Callable[[], bool]) -> None:
        until_s = self.reactor.now() + 60.0

        def look() -> None:
            if is_so() or self.reactor.now() > until_s:
                self.reactor.stop()
            self.reactor.call_later(PARTIAL_LINE_S / 10, look)

        look()
        self.reactor.run()


BEGUN_AND_ENDED = {
    "a line": (b"one half and ", b"the other half\n"),
    "a traceback": (
        b'Traceback (most recent call last):\n  File "a.py", line 1, in <module>\n',
        b"    1 / 0\nZeroDivisionError: division by zero\n",
    ),
}


@pytest.mark.parametrize("what", BEGUN_AND_ENDED)
def test_output_of_another_host_that_comes_late_stays_whole(tmp_path: Path, what: str):
    begun, ended = BEGUN_AND_ENDED[what]
    with Reactor() as reactor:
        bench = ReaderBench(tmp_path, reactor)
        bench.feed(begun)

        def meanwhile() -> None:
            os.write(bench.b, b"somebody else\n")
            reactor.call_later(3 * PARTIAL_LINE_S, lambda: bench.feed(ended))

        bench.delay(meanwhile)
        lines = bench.shown(ended)
        assert lines[0] == b"[b] somebody else"
        assert b"\n".join(lines).replace(b"[remote] ", b"").endswith((begun + ended).rstrip(b"\n"))
        bench.close()


def test_what_another_host_has_not_finished_is_shown_if_the_process_is_silent(tmp_path: Path):
    with Reactor() as reactor:
        bench = ReaderBench(tmp_path, reactor)
        bench.feed(b"your name? ")
        bench.feed(b"")
        assert bench.shown(b"[remote] your name? ") == [b"[remote] your name? "]
        bench.close()


def test_only_what_is_written_is_output(tmp_path: Path):
    with Reactor() as reactor:
        bench = ReaderBench(tmp_path, reactor)
        bench.feed(b"your name? ")
        read_at_s = bench.relay.read_at_s
        assert read_at_s > 0
        bench.feed(b"")  # it is silent
        bench.end(bench.a)
        assert bench.relay.read_at_s == read_at_s
        bench.close()


@pytest.mark.parametrize("what", BEGUN_AND_ENDED)
def test_output_written_while_the_loop_was_delayed_is_read_before_the_process_is_quiet(
    tmp_path: Path, what: str
):
    begun, ended = BEGUN_AND_ENDED[what]
    with Reactor() as reactor:
        bench = ReaderBench(tmp_path, reactor)
        os.write(bench.a, begun)

        def meanwhile() -> None:
            os.write(bench.b, b"somebody else\n")  # whoever wrote first is read first
            os.write(bench.a, ended)

        reactor.call_later(0, lambda: bench.delay(meanwhile))
        shown = bench.shown(b"somebody else\n")
        bench.close()
    whole = [b"[a] " + line for line in (begun + ended).splitlines()]
    assert shown == [*whole, b"[b] somebody else"]


# ---- a whole run

# Writes every line in two pieces, and now and then a traceback in two, until there are enough.
CHILD = """
import os, sys, time
name, enough, number = sys.argv[1], sys.argv[2], 0
while not (number % 100 == 0 and os.path.exists(enough)):
    number += 1
    text = f"{name} line {number} {'x' * (number % 60)}\\n".encode()
    os.write(1, text[: number % len(text)])
    os.write(1, text[number % len(text) :])
    if number % 100 == 50:
        os.write(1, b"Traceback (most recent call last):\\n  frame 1 of %d\\n" % number)
        os.write(1, b"  frame 2\\nValueError: %d\\n" % number)
    if number % 100 == 0:
        time.sleep(0.01)  # bounded files
"""
CHILDREN = 8
STOPS = 6


def lines_of(name: str, count: int) -> list[str]:
    """The same lines."""
    lines = []
    for number in range(1, count + 1):
        lines.append(f"{name} line {number} {'x' * (number % 60)}")
        if number % 100 == 50:
            lines += ["Traceback (most recent call last):", f"  frame 1 of {number}"]
            lines += ["  frame 2", f"ValueError: {number}"]
    return lines


def test_stopped_again_and_again_under_floods_it_shows_and_files_every_line_whole(bench: Bench):
    (bench.folder / "child.py").write_text(CHILD)
    enough, screen = bench.folder / "enough", bench.folder / "screen"
    command = f'[sys.executable, "-S", "{bench.folder}/child.py", f"c{{n}}", "{enough}"]'
    options = 'name=f"c{n}", output="screen", emulate_tty=n % 2 == 0'
    actions = f"*[ExecuteProcess(cmd={command}, {options}) for n in range({CHILDREN})]"
    with screen.open("wb") as file:
        launcher = psutil.Popen(bench.command(actions), env=bench.env, stdout=file)

    def all_are_shown() -> bool:
        shown = screen.read_text()
        return all(f"[c{n}-{n + 1}] c{n} line " in shown for n in range(CHILDREN))

    wait_until(all_are_shown, "lines of each")
    for _ in range(STOPS):
        before = screen.stat().st_size
        wait_until(lambda before=before: screen.stat().st_size > before + 100_000, "much is shown")
        hold_up(launcher)
    enough.touch()
    assert launcher.wait(60) == 0
    shown = [line for line in screen.read_text().splitlines() if line.startswith("[c")]
    assert_whole(shown)
    for path in (bench.folder / "log/latest").glob("c*.log"):
        of_one = [line for line in shown if line.startswith(f"[{path.stem}]")]
        own_words = re.compile(r"process (started|has finished)")
        assert path.read_text().splitlines() == [x for x in of_one if not own_words.search(x)]


def hold_up(launcher: psutil.Popen) -> None:
    """Stop it for longer than any line is waited for."""
    launcher.suspend()
    wait_until(lambda: launcher.status() == psutil.STATUS_STOPPED, "a stopped launcher")
    goes_on_s = time.monotonic() + 3 * PARTIAL_LINE_S
    wait_until(lambda: time.monotonic() > goes_on_s, "its children have waited for it")
    launcher.resume()


def assert_whole(shown: list[str]) -> None:
    """Every line of every child, in order, and no traceback with others' lines in it."""
    seen = defaultdict(list)
    for line in shown:
        name, _, text = line[1:].partition("-")
        seen[name].append(text.partition("] ")[2])
    assert len(seen) == CHILDREN
    for name, lines in seen.items():
        count = sum(line.startswith(f"{name} line ") for line in lines)
        assert lines == lines_of(name, count)
    for number, line in enumerate(shown):
        if "Traceback" in line:
            prefix = line.partition("]")[0]
            assert all(after.startswith(prefix) for after in shown[number : number + 4])
