"""Verbs of the command line in the console: each is a process, one at a time."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shlex
import signal
import subprocess
import time
from collections import deque
from collections.abc import Mapping, Sequence

from launcher.control.active_runs import ListedRun
from launcher.control.console.display import GUTTER, Display
from launcher.control.console.feed import Feed
from launcher.control.console.guard import guarded
from launcher.control.console.terminal import Terminal

COMPLETION_S = 5.0  # for the answer to a Tab
GRACE_S = 0.5  # a Ctrl-C so soon after the end of a verb was meant for that


class ShellVerbs:
    """Runs them in the environment of the run; their output appears as answers do.

    Each has a guard (`guard.py`), which ends it when the console ends. Ctrl-C ends the one that
    runs, and leaves out those that wait for it.
    """

    def __init__(self, run: ListedRun, display: Display, terminal: Terminal) -> None:
        self._run = run
        self._display = display
        self._terminal = terminal
        self._running: _Process | None = None
        self._waiting: deque[Sequence[str]] = deque()
        self._ended_s = 0.0

    @property
    def hint(self) -> str:
        """What the status bar says while one runs; else empty."""
        if self._running is None:
            return ""
        return f"Ctrl-C ends `{self._running.line}`"

    async def run(self, words: Sequence[str]) -> None:
        """Run a verb to its end, or later if another one is running."""
        if self._running is not None:
            self._waiting.append(words)
            line = self._running.line
            self._display.answer(f"waits until `{line}` has ended; Ctrl-C ends that one")
            return
        await self._run_one(words)
        while self._waiting:
            words = self._waiting.popleft()
            self._display.echo(shlex.join(words))
            await self._run_one(words)

    async def candidates(self, words: Sequence[str]) -> Sequence[tuple[str, str]]:
        """Completions of the last word, each with a text about it; none in case of doubt."""
        env = environment(os.environ, self._run.domain_id, 80)
        orders, lifeline = os.pipe()
        try:
            process = await asyncio.create_subprocess_exec(
                *guarded(["completion", "zsh", *words], orders),
                env=env,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                pass_fds=[orders],
                start_new_session=True,
            )
            output, _ = await asyncio.wait_for(process.communicate(), COMPLETION_S)
        except (asyncio.TimeoutError, OSError):
            return ()
        finally:
            os.close(orders)
            os.close(lifeline)  # ends it, if it has not ended
        pairs = (line.partition("\t") for line in output.decode(errors="replace").splitlines())
        return [(value, text) for value, _, text in pairs]

    async def _run_one(self, words: Sequence[str]) -> None:
        columns = max(1, self._terminal.size().columns - len(GUTTER))
        process = _Process(words, environment(os.environ, self._run.domain_id, columns))
        self._running = process
        self._footer_changed()
        try:
            code = await process.to_its_end(self._display)
        finally:
            self._running = None
            if not process.is_interrupted:
                self._ended_s = time.monotonic()
            self._footer_changed()
        if code and not process.is_interrupted:
            self._display.answer(f"exit code {code}")

    def interrupt(self) -> bool:
        """Ctrl-C: end the one that runs, at once the second time; False if none is meant."""
        if self._running is None:
            return time.monotonic() - self._ended_s < GRACE_S
        if self._waiting:
            lines = ", ".join(f"`{shlex.join(words)}`" for words in self._waiting)
            self._display.answer(f"left out: {lines}")
            self._waiting.clear()
        self._running.interrupt()
        return True

    def hold_back(self, slow: bool) -> None:
        """Do not read output while the terminal is slow."""
        if self._running is not None:
            self._running.hold_back(slow)

    def _footer_changed(self) -> None:
        self._display.footer_changed()
        self._display.application.invalidate()


class _Process:
    """A verb, from its start to its end."""

    def __init__(self, words: Sequence[str], env: Mapping[str, str]) -> None:
        self.line = shlex.join(words)
        self.is_interrupted = False
        self._words = words
        self._env = env
        self._lifeline = -1
        self._feed: Feed | None = None

    async def to_its_end(self, display: Display) -> int:
        """Start it, and show what it writes; the exit code."""
        loop = asyncio.get_running_loop()
        output, theirs = os.pipe()
        orders, self._lifeline = os.pipe()
        try:
            guard = subprocess.Popen(
                guarded([*self._words], orders),
                env=dict(self._env),
                stdin=subprocess.DEVNULL,
                stdout=theirs,
                stderr=theirs,
                pass_fds=[orders],
                start_new_session=True,
            )
            for fd in (theirs, orders):
                os.close(fd)
            theirs = orders = -1
            self._feed = Feed(loop, output, lambda lines, _: display.passed_on(lines), _nothing)
            await _exit_of(guard.pid)
            self._feed.finish()  # something that it has left may keep the pipe open
            return guard.wait()
        finally:
            self._feed = None
            for fd in (output, theirs, orders, self._lifeline):
                if fd >= 0:
                    os.close(fd)

    def interrupt(self) -> None:
        """SIGINT for it and what it has started; SIGKILL the second time."""
        signum = signal.SIGKILL if self.is_interrupted else signal.SIGINT
        self.is_interrupted = True
        with contextlib.suppress(BrokenPipeError):  # it has ended
            os.write(self._lifeline, bytes([signum]))

    def hold_back(self, slow: bool) -> None:
        if self._feed is not None:
            self._feed.hold_back(slow)


def _nothing() -> None:
    """The end of the output is not the end of the process."""


async def _exit_of(pid: int) -> None:
    """Return when a child has exited; it is not waited for."""
    loop, pidfd = asyncio.get_running_loop(), os.pidfd_open(pid)
    exited = asyncio.Event()
    loop.add_reader(pidfd, exited.set)
    try:
        await exited.wait()
    finally:
        loop.remove_reader(pidfd)
        os.close(pidfd)


def environment(base: Mapping[str, str], domain_id: int | None, columns: int) -> dict[str, str]:
    """That of the launcher, with the domain of the run; lines come as they are printed."""
    domain = {} if domain_id is None else {"ROS_DOMAIN_ID": str(domain_id)}
    return {**base, **domain, "COLUMNS": str(columns), "PYTHONUNBUFFERED": "1"}
