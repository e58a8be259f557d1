"""Session: one console, from its first look at the run to the run's end."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import threading
from collections import deque
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any, TypeVar

from prompt_toolkit.application.run_in_terminal import in_terminal

from launcher.console import requests
from launcher.console.bar import Line, fitted, folder_line, status_line
from launcher.console.completion import WordCompleter
from launcher.console.display import GUTTER, Display
from launcher.console.feed import Feed
from launcher.console.history import history_path, open_history
from launcher.console.prompt import make_application
from launcher.console.terminal import Terminal
from launcher.console.watch import Watch
from launcher.control.runs import Run
from launcher.control.socket_directory import ControlError
from launcher.control.verbs import Call, find, parse
from launcher.errors import UsageError

T = TypeVar("T")
HOLD_S = 0.5  # how long a line waits for the answer to the one before
LOOK_S = 1.0  # how often the bar is brought up to date
LAST_WORDS_S = 2.0  # how long a slow terminal is waited for at the end
FOREGROUND_LOOK_S = 0.2
NOT_STOPPED_S = 0.5  # SIGCONT is there as soon as we are, if we were stopped at all


async def in_thread(work: Callable[[], T]) -> T:
    """Do blocking work beside the loop. Unlike an executor's, the thread holds up no end."""
    loop = asyncio.get_running_loop()
    done: asyncio.Future[T] = loop.create_future()

    def deliver(put: Callable[[Any], None], value: object) -> None:
        if not done.done():
            put(value)

    def run() -> None:
        try:
            result = work()
        except BaseException as error:
            outcome: tuple[Any, object] = (done.set_exception, error)
        else:
            outcome = (done.set_result, result)
        with contextlib.suppress(RuntimeError):  # the loop is closed: nobody waits any more
            loop.call_soon_threadsafe(deliver, *outcome)

    threading.Thread(target=run, daemon=True).start()
    return await done


def _below_home(path: str) -> str:
    home = os.path.expanduser("~") + "/"
    return f"~/{path.removeprefix(home)}" if path.startswith(home) else path


class Session:
    """The console of `run`. `run_until_end()` returns whether the launcher has said goodbye."""

    def __init__(self, run: Run, feed_fd: int, link: socket.socket, *, colour: bool) -> None:
        self._run = run
        self._feed_fd = feed_fd
        self._link = link
        self._loop = asyncio.get_running_loop()
        self._terminal = Terminal(self._loop)
        self._display = Display(self._terminal, colour=colour)
        self._processes: Sequence[Mapping[str, Any]] = ()
        self._tasks: set[asyncio.Future[Any]] = set()
        self._lines: deque[str] = deque()
        self._is_answering = False
        self._watch: Watch | None = None
        self._fault: BaseException | None = None
        self._has_goodbye = False
        self._going_on: asyncio.Event | None = None
        self._feed: Feed | None = None
        self._application = make_application(
            self,
            self,
            output=self._display.output,
            completer=WordCompleter(lambda: self._processes),
            history=open_history(history_path(os.environ)),
            colour=colour,
        )
        self._display.application = self._application

    # ---- from the beginning to the end

    async def run_until_end(self) -> bool:
        """Show and listen until the launcher has closed its end."""
        await self._look_again()
        if not await self._is_given_the_terminal():
            return False
        self._loop.set_exception_handler(self._failed)
        self._loop.add_signal_handler(signal.SIGCONT, self._continued)
        self._terminal.on_gone = self._end
        self._display.has_footer = True
        try:
            with contextlib.suppress(EOFError):  # the terminal hung up
                await self._application.run_async(
                    self._begin, set_exception_handler=False, handle_sigint=False
                )
        finally:
            self._display.has_footer = False
            self._terminal.drain(LAST_WORDS_S)
        if self._fault is not None:
            raise self._fault
        return self._has_goodbye

    async def _is_given_the_terminal(self) -> bool:
        """Say that we are ready; from the answer on, the launcher writes only to us."""
        self._link.setblocking(False)
        await self._loop.sock_sendall(self._link, b"R")
        if await self._loop.sock_recv(self._link, 1) != b"G":
            return False
        self._loop.add_reader(self._link, self._hear)
        return True

    def _begin(self) -> None:
        self._terminal.write(b"\r")
        self._feed = Feed(self._loop, self._feed_fd, self._display.show, self._launcher_ended)
        self._terminal.on_slow = self._feed.hold_back
        self._do(self._keep_looking())

    def _hear(self) -> None:
        """The launcher's goodbye, or its death, which its children may hide from the feed."""
        word = self._link.recv(1)
        self._has_goodbye = self._has_goodbye or word == b"B"
        if not word:
            self._loop.remove_reader(self._link)
            if self._feed is not None:
                self._feed.finish()

    def _end(self) -> None:
        if self._application.is_running and not self._application.is_done:
            self._application.exit()

    def _launcher_ended(self) -> None:
        with contextlib.suppress(BlockingIOError, ConnectionError):
            self._has_goodbye = self._has_goodbye or b"B" in self._link.recv(1)
        if not self._has_goodbye and not self._terminal.is_ours():
            # The shell has noticed sooner than we have: its prompt is where ours was, and its
            # settings are in force. What prompt_toolkit puts back would not be theirs.
            self._terminal.write(b"\x1b[?25h\x1b[?7h\x1b[J\r\n")
            self.tell_of_death()
            os._exit(0)
        self._end()

    def tell_of_death(self) -> None:
        """The launcher is gone without a goodbye: say so, as the last line."""
        text = "the launcher was killed; everything that it had started is ended by its watchdog"
        self._terminal.write(f"[ERROR] [console]: {text}\r\n".encode())
        self._terminal.drain(LAST_WORDS_S)

    def restore(self) -> None:
        """The settings of the terminal as they were."""
        self._terminal.restore()

    def _failed(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """An error of our own in a callback: end, and let the launcher take over."""
        self._fault = self._fault or context.get("exception") or RuntimeError(context["message"])
        self._end()

    def _do(self, work: Awaitable[None]) -> None:
        """Do it beside everything else; what it raises is a fault of ours."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._done)

    def _done(self, task: asyncio.Future[Any]) -> None:
        self._tasks.discard(task)
        error = None if task.cancelled() else task.exception()
        if error is not None:
            self._failed(self._loop, {"exception": error, "message": str(error)})

    # ---- the footer

    def _look(self) -> Sequence[Mapping[str, Any]]:
        with self._run.connect() as connection:
            found: Sequence[Mapping[str, Any]] = connection.ask("ps").result["processes"]
            return found

    async def _keep_looking(self) -> None:
        while True:
            await asyncio.sleep(LOOK_S)
            await self._look_again()

    async def _look_again(self) -> None:
        with contextlib.suppress(ControlError):  # it is busy, or ends, which the feed tells, too
            self._processes = await in_thread(self._look)
        if self._display.has_footer:
            self._application.invalidate()

    def above(self) -> str:
        """A live table, or the line of a process that has no end yet."""
        if self._watch is not None and (table := self._watch.text()):
            return table
        return self._display.partial.decode(errors="replace")

    def status(self, columns: int, *, few: bool) -> Sequence[Line]:
        """Processes, and where the files of the run are; while one watches, what keys do."""
        lines = [status_line(self._processes, columns), self._about_the_run(columns)]
        return lines[-1:] if few and self._watch is not None else lines[: 1 if few else 2]

    def _about_the_run(self, columns: int) -> Line:
        if self._watch is not None and self.is_watching():
            return fitted([("class:bar.waiting", self._watch.hint)], columns)
        return folder_line(_below_home(self._run.log_dir or "no log files"), columns)

    # ---- what a person does

    def entered(self, line: str) -> None:
        """Do what the line says, after those that were entered before it."""
        if line.strip():
            self._lines.append(line)
        if self._lines and not self._is_answering:
            self._is_answering = True
            self._do(self._answer_lines())

    async def _answer_lines(self) -> None:
        """One after the other, each answer below its line; a stop that takes long holds up none."""
        try:
            while self._lines:
                line = self._lines.popleft()
                self._display.echo(line)
                work = asyncio.ensure_future(self._answer(line))
                self._do(work)
                await asyncio.wait({work}, timeout=HOLD_S)
                if self._watch is not None:
                    await asyncio.wait({work})
        finally:
            self._is_answering = False

    async def _answer(self, line: str) -> None:
        try:
            call = requests.read_call(line)
            await (self._follow(call) if requests.follows(call) else self._ask(call))
        except UsageError as error:
            self._tell_of(error)
        except Exception as error:  # whatever became of one line, the console goes on
            told = UsageError(f"'{line}' failed: {type(error).__name__}: {error}")
            self._tell_of(told)

    def _tell_of(self, error: UsageError) -> None:
        self._display.answer(requests.problem(error, self._columns(), colour=self._display.colour))

    def _columns(self) -> int:
        """What an answer has, beside its mark."""
        return max(1, self._terminal.size().columns - len(GUTTER))

    async def _ask(self, call: Call) -> None:
        columns, colour = self._columns(), self._display.colour
        text = await in_thread(lambda: requests.answer(self._run, call, columns, colour=colour))
        if self._feed is not None:
            self._feed.catch_up()  # what the launcher had said before stands above
        self._display.answer(text)
        await self._look_again()

    async def _follow(self, call: Call) -> None:
        watch = self._watch = Watch(self._run, call, self._display, self._terminal.size)
        try:
            await in_thread(lambda: watch.run(self._loop))
        finally:
            self._watch = None
            self._application.invalidate()

    def any_key(self, key: str) -> None:
        """Scroll or end what is being watched."""
        if self._watch is not None:
            self._watch.press(key)

    def is_watching(self) -> bool:
        """Whether something is, and no key has ended it yet."""
        return self._watch is not None and not self._watch.is_closed

    def signalled(self, signum: int) -> None:
        """Hand it on: the launcher knows what a second and a third one mean.

        While something is watched, the first one ends that: who types it in `logs -f` has the
        habit of other programs, and does not mean the robots.
        """
        self._lines.clear()
        if signum == signal.SIGINT and self._watch is not None and self.is_watching():
            self._watch.close()
            return
        self._display.say("^C" if signum == signal.SIGINT else "^\\")
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._run.pid, signum)

    def left(self) -> None:
        """Ctrl-D stops the run."""
        verb = find("quit")
        assert verb is not None
        self._display.echo("quit")
        self._do(self._ask(parse(verb, ())))

    # ---- suspended and continued

    def suspended(self) -> None:
        """Stop everybody in our job, with the terminal as it was."""
        self._do(self._suspend())

    async def _suspend(self) -> None:
        async with in_terminal():
            self._display.has_footer = False
            self._terminal.drain(LAST_WORDS_S)
            self._going_on = asyncio.Event()
            os.kill(0, signal.SIGTSTP)
            # Where it had no effect (nobody would continue us) there is nothing to wait for.
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._going_on.wait(), NOT_STOPPED_S)
            self._going_on = None
            while not self._terminal.is_ours():  # `bg`: lines go on, the keyboard is the shell's
                await asyncio.sleep(FOREGROUND_LOOK_S)
        self._display.has_footer = True
        self._application.invalidate()

    def _continued(self) -> None:
        """If somebody else had stopped us: a shell has changed the terminal meanwhile."""
        if self._going_on is not None:
            self._going_on.set()
        elif self._display.has_footer:
            self._do(self._come_back())

    async def _come_back(self) -> None:
        self._display.has_footer = False
        with self._application.input.detach():
            while not self._terminal.is_ours():
                await asyncio.sleep(FOREGROUND_LOOK_S)
        self._terminal.set_raw()
        self._terminal.write(b"\r\x1b[J")
        self._application.renderer.reset()
        self._display.has_footer = True
        self._application.invalidate()
