"""A console session, from the handover of the terminal to the end of the run."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import threading
from collections import deque
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any, TypeVar

from prompt_toolkit.application.run_in_terminal import in_terminal

from launcher.base.errors import UsageError
from launcher.base.run_verb import Call
from launcher.base.text import typed_error
from launcher.control.active_runs import ListedRun
from launcher.control.console.bar import Line, status_lines
from launcher.control.console.completion import WordCompleter
from launcher.control.console.display import GUTTER, Display
from launcher.control.console.feed import Feed
from launcher.control.console.help_view import HelpView
from launcher.control.console.history_file import history_path
from launcher.control.console.panel import Panel
from launcher.control.console.prompt import make_application, open_history
from launcher.control.console.requests import (
    CLEAR,
    answer,
    follows,
    problem,
    read_call,
    read_shell_words,
    split,
)
from launcher.control.console.shell_verbs import ShellVerbs
from launcher.control.console.short_forms import killed_text
from launcher.control.console.stream_view import StreamView
from launcher.control.console.terminal import Terminal
from launcher.control.verbs import find, parse
from launcher.posix.socket_directory import ControlError

T = TypeVar("T")
HOLD_S = 0.5  # longest wait of a line for the answer to the previous one
POLL_S = 1.0  # between two updates of the status bar
FOREGROUND_POLL_S = 0.2
NOT_STOPPED_S = 0.5  # without SIGCONT, after which SIGTSTP had no effect


async def in_thread(work: Callable[[], T]) -> T:
    """Run blocking `work` in a daemon thread: unlike an executor's, it cannot delay the exit."""
    done: Future[T] = Future()
    done.set_running_or_notify_cancel()  # so that nothing can cancel it

    def run() -> None:
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return await asyncio.wrap_future(done)


def _below_home(path: str) -> str:
    home = os.path.expanduser("~") + "/"
    return f"~/{path.removeprefix(home)}" if path.startswith(home) else path


class ConsoleSession:
    """The console of `run`; `feed_fd` is the output of the launcher, `link` the handover."""

    def __init__(self, run: ListedRun, feed_fd: int, link: socket.socket, *, colour: bool) -> None:
        self._run = run
        self._feed_fd = feed_fd
        self._link = link
        self._loop = asyncio.get_running_loop()
        self._terminal = Terminal(self._loop)
        self._display = Display(self._terminal, colour=colour)
        self.panel = Panel(
            run, self._display, self._terminal, lambda: self._processes, self.entered
        )
        self.help = HelpView(self._display)
        self._shell_verbs = ShellVerbs(run, self._display, self._terminal)
        self._processes: Sequence[Mapping[str, Any]] = ()
        self._page = ""  # its link, if one is served
        self._faults = 0  # that are active
        self._tasks: set[asyncio.Future[Any]] = set()
        self._lines: deque[str] = deque()
        self._is_answering = False
        self._watch: StreamView | None = None
        self._fault: BaseException | None = None
        self._has_goodbye = False
        self._continue: asyncio.Event | None = None
        self._feed: Feed | None = None
        self._application = make_application(
            self,
            output=self._display.output,
            completer=WordCompleter(lambda: self._processes, self._shell_verbs.candidates),
            history=open_history(history_path(os.environ)),
            colour=colour,
        )
        self._display.application = self._application

    # ---- start and end

    async def run_until_end(self) -> bool:
        """Run until the launcher closes its end; False if it did so without a goodbye."""
        await self._refresh()
        if not await self._take_terminal():
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
            self._terminal.drain()
        if self._fault is not None:
            raise self._fault
        return self._has_goodbye

    async def _take_terminal(self) -> bool:
        """Handshake; after it the launcher writes to the feed, not to the terminal."""
        self._link.setblocking(False)
        await self._loop.sock_sendall(self._link, b"R")
        if await self._loop.sock_recv(self._link, 1) != b"G":
            return False
        self._loop.add_reader(self._link, self._read_link)
        return True

    def _begin(self) -> None:
        self._terminal.write(b"\r")
        self._feed = Feed(self._loop, self._feed_fd, self._display.show, self._launcher_ended)
        self._terminal.on_slow = self._slow
        self._do(self._poll_forever())

    def _slow(self, slow: bool) -> None:
        if self._feed is not None:
            self._feed.hold_back(slow)
        self._shell_verbs.hold_back(slow)

    def _read_link(self) -> None:
        """Read the goodbye, or EOF: children may keep the feed open after the launcher exits."""
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
            # The shell has already set the terminal and printed its prompt; the settings that
            # prompt_toolkit would restore are older.
            self._terminal.write(b"\x1b[?25h\x1b[?7h\x1b[J\r\n")
            self.report_kill()
            os._exit(0)
        self._end()

    def report_kill(self) -> None:
        """Write a last line: the launcher was killed."""
        self._terminal.write(f"[ERROR] [console]: {killed_text(self._processes)}\r\n".encode())
        self._terminal.drain()

    def restore(self) -> None:
        self._terminal.restore()

    def _failed(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """End after an exception in a callback; the launcher writes to the terminal again."""
        self._fault = self._fault or context.get("exception") or RuntimeError(context["message"])
        self._end()

    def _do(self, work: Awaitable[None]) -> None:
        """Start a task; an exception in it ends the console."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._done)

    def _done(self, task: asyncio.Future[Any]) -> None:
        self._tasks.discard(task)
        error = None if task.cancelled() else task.exception()
        if error is not None:
            self._failed(self._loop, {"exception": error, "message": str(error)})

    # ---- the footer

    def _query(self) -> Sequence[Mapping[str, Any]]:
        with self._run.connect() as connection:
            self._page = str(connection.hello.get("page", ""))
            self._faults = int(connection.hello.get("active_faults", 0))
            found: Sequence[Mapping[str, Any]] = connection.ask("ps").result["processes"]
            return found

    async def _poll_forever(self) -> None:
        while True:
            await asyncio.sleep(POLL_S)
            await self._refresh()

    async def _refresh(self) -> None:
        with contextlib.suppress(ControlError):  # the run is busy or ending
            self._processes = await in_thread(self._query)
        if self._display.has_footer:
            self._application.invalidate()

    # ---- for the prompt: the text around it, and its keys

    def above(self) -> str:
        """Lines above the prompt, with SGR sequences; may be empty."""
        if self._watch is not None and (table := self._watch.text()):
            return table
        return self._display.partial.decode(errors="replace")

    def status(self, columns: int, *, few: bool) -> Sequence[Line]:
        """Lines of the status bar; one of them where there are `few` rows."""
        folder = _below_home(self._run.log_dir or "no log files")
        hint = self.panel.hint(columns) or self._shell_verbs.hint or self.help.hint
        if self._watch is not None and self.is_watching():
            hint = self._watch.hint
        return status_lines(
            self._processes,
            folder,
            columns,
            hint=hint,
            few=few,
            page=self._page,
            faults=self._faults,
        )

    # ---- input

    def entered(self, line: str) -> None:
        self.help.close()
        if line.strip():
            self._lines.append(line)
        if self._lines and not self._is_answering:
            self._is_answering = True
            self._do(self._answer_lines())

    async def _answer_lines(self) -> None:
        """Answer one by one, each below its line; the next line waits at most HOLD_S."""
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
            if split(line) == [CLEAR]:
                self._application.renderer.clear()
                return
            if (words := read_shell_words(line)) is not None:
                await self._shell_verbs.run(words)
                return
            call = read_call(line)
            if call.verb.name == "pick":
                self.panel.open()
                return
            if call.verb.name == "help" and not call.options:
                self.help.open()
                return
            await (self._follow(call) if follows(call) else self._ask(call))
        except UsageError as error:
            self._show_error(error)
        except Exception as error:  # one bad line must not end the console
            self._show_error(UsageError(f"'{line}' failed: {typed_error(error)}"))

    def _show_error(self, error: UsageError) -> None:
        self._display.answer(problem(error, self._columns(), colour=self._display.colour))

    def _columns(self) -> int:
        return max(1, self._terminal.size().columns - len(GUTTER))

    async def _ask(self, call: Call) -> None:
        columns, colour = self._columns(), self._display.colour
        text = await in_thread(lambda: answer(self._run, call, columns, colour=colour))
        if self._feed is not None:
            self._feed.catch_up()  # show first what the launcher wrote before the answer
        if text:
            self._display.answer(text)
        await self._refresh()

    async def _follow(self, call: Call) -> None:
        self.panel.close()
        watch = self._watch = StreamView(self._run, call, self._display, self._terminal.size)
        try:
            await in_thread(lambda: watch.run(self._loop))
        finally:
            self._watch = None
            self._application.invalidate()

    def any_key(self, key: str, text: str) -> None:
        """Handle a key, given by name and text, while a stream or the panel is shown."""
        if self.panel.is_open:
            self.panel.press(key, text)
        elif self._watch is not None:
            self._watch.press(key)

    def is_watching(self) -> bool:
        """Whether the next key goes to `any_key`."""
        return self._watch is not None and not self._watch.is_closed

    def signalled(self, signum: int) -> None:
        """Send the signal to the launcher, which escalates at each further one.

        Ctrl-C while a stream or the picker is shown, or a verb of shells runs, ends only that, as
        in `tail -f`.
        """
        self._lines.clear()
        if signum == signal.SIGINT and self.panel.is_open:
            self.panel.close()
            return
        if signum == signal.SIGINT and self._watch is not None and self.is_watching():
            self._watch.close()
            return
        if signum == signal.SIGINT and self._shell_verbs.interrupt():
            self._display.show_text("^C")
            return
        self._display.show_text("^C" if signum == signal.SIGINT else "^\\")
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._run.pid, signum)

    def left(self) -> None:
        """Ctrl-D on an empty line."""
        verb = find("quit")
        assert verb is not None
        self._display.echo("quit")
        self._do(self._ask(parse(verb, ())))

    # ---- suspend and resume

    def suspended(self) -> None:
        """Ctrl-Z."""
        self._do(self._suspend())

    async def _suspend(self) -> None:
        async with in_terminal():
            self._display.has_footer = False
            self._terminal.drain()
            self._continue = asyncio.Event()
            os.kill(0, signal.SIGTSTP)
            # Without effect in an orphaned process group, which no shell could resume.
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._continue.wait(), NOT_STOPPED_S)
            self._continue = None
            while not self._terminal.is_ours():  # `bg`: output continues, keys go to the shell
                await asyncio.sleep(FOREGROUND_POLL_S)
        self._display.has_footer = True
        self._application.invalidate()

    def _continued(self) -> None:
        """After SIGCONT; unless we sent SIGTSTP, a shell has changed the terminal meanwhile."""
        if self._continue is not None:
            self._continue.set()
        elif self._display.has_footer:
            self._do(self._resume())

    async def _resume(self) -> None:
        self._display.has_footer = False
        with self._application.input.detach():
            while not self._terminal.is_ours():
                await asyncio.sleep(FOREGROUND_POLL_S)
        self._terminal.set_raw()
        self._terminal.write(b"\r\x1b[J")
        self._application.renderer.reset()
        self._display.has_footer = True
        self._application.invalidate()
