"""The process of the members: it starts them, passes on signals, and ends with them."""

from __future__ import annotations

import collections
import contextlib
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence

from launcher.ros.composed import (
    context,
    control,
    current,
    member_output,
    member_program,
    member_signals,
)
from launcher.ros.composed.member import Member
from launcher.ros.helpers.clean_up import limited_clean_up

Task = Callable[[], None]

_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_NEXT_S = 5.0  # as the launcher stops processes: SIGINT, then SIGTERM, then SIGKILL


class Tasks:
    """What the main thread is to do next: put by any thread, and by handlers of signals.

    A `SimpleQueue` can miss a signal: one that arrives just before the main thread sleeps on its
    lock runs its handler only after the next task, which may never come. This sleeps on a pipe,
    into which Python writes at each signal.
    """

    def __init__(self) -> None:
        self._tasks: collections.deque[Task] = collections.deque()
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        os.set_blocking(self._writer, False)
        self._poll = select.poll()
        self._poll.register(self._reader, select.POLLIN)
        signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)

    def put(self, task: Task) -> None:
        self._tasks.append(task)
        with contextlib.suppress(BlockingIOError):  # it is full, and wakes the main thread anyway
            os.write(self._writer, b"\0")

    def get(self, timeout_s: float | None = None) -> Task | None:
        """The next task; `None` if there is none for this time, or if a signal came in between."""
        if not self._tasks:
            self._poll.poll(None if timeout_s is None else timeout_s * 1000)
            with contextlib.suppress(BlockingIOError):
                os.read(self._reader, 4096)
        return self._tasks.popleft() if self._tasks else None


class Group:
    """Runs in the main thread; everything else reaches it through `_tasks`."""

    def __init__(self, members: Sequence[Member]) -> None:
        self._members = members
        self._tasks = Tasks()
        self._running = len(members)
        self._code = 0
        self._is_stopping = self._is_ending = False
        self._escalation: list[tuple[float, Task]] = []

    def run(self) -> int:
        """The exit code of the process, negative for a signal."""
        for signum in _STOP_SIGNALS:
            self._hear(signum)
        threading.Thread(target=self._take_requests, daemon=True).start()
        for one in self._members:
            one.start(lambda member: self._tasks.put(lambda: self._ended(member)))
        while self._running:
            self._next()()
        with limited_clean_up():
            context.close_shared()
        return self._code

    def _next(self) -> Task:
        """What is to be done next, as soon as there is something."""
        while True:
            due_s = self._escalation[0][0] - time.monotonic() if self._escalation else None
            if due_s is not None and due_s <= 0:
                return self._escalation.pop(0)[1]
            if task := self._tasks.get(due_s):
                return task

    def forward(self, signum: int) -> None:
        """Hear of a signal from now on; for all threads."""
        self._tasks.put(lambda: self._hear(signum))

    def _hear(self, signum: int) -> None:
        signal.signal(signum, lambda number, _: self._tasks.put(lambda: self._signalled(number)))

    def _signalled(self, signum: int) -> None:
        self._is_stopping = self._is_stopping or signum in _STOP_SIGNALS
        for one in self._members:
            member_signals.deliver(one, signum)

    def _ended(self, one: Member) -> None:
        one.wait()
        self._running -= 1
        code = one.exit_code or 0
        control.send(one.index, "exit", code)
        if not self._is_ending:  # else its code is that of the one that ends all
            self._code = self._code or code
        if (code or one.is_essential) and not self._is_stopping:
            self._is_ending = True
            self._stop()

    def _stop(self) -> None:
        """A member has failed, or is one that the others do not go on without."""
        now = time.monotonic()
        self._escalation = [
            (now + _NEXT_S, lambda: self._signalled(signal.SIGTERM)),
            (now + 2 * _NEXT_S, lambda: os._exit((self._code or 1) & 0xFF)),
        ]
        self._signalled(signal.SIGINT)

    # ---- the launcher

    def _take_requests(self) -> None:
        for index, signum in control.requests():
            if index < len(self._members):
                self._tasks.put(self._request(index, signum))

    def _request(self, index: int, signum: int) -> Task:
        return lambda: member_signals.deliver(self._members[index], signum)


def members_of(words: Sequence[str]) -> list[Member]:
    """From `[--essential] NAME COUNT WORD ...` for each."""
    found: list[Member] = []
    rest = list(words)
    while rest:
        is_essential = rest[0] == "--essential"
        name, count, *rest = rest[is_essential:]
        argv, rest = rest[: int(count)], rest[int(count) :]
        found.append(Member(len(found), name, argv, is_essential=is_essential))
    return found


def main() -> None:
    control.take()
    group = Group(members_of(sys.argv[1:]))
    if sys.path and sys.path[0] in ("", os.getcwd()):
        del sys.path[0]  # a console script would not have it
    member_output.install()
    current.inherit()
    member_program.install()
    context.install()
    member_signals.install(group.forward)
    code = group.run()
    if code == -signal.SIGINT:
        sys.excepthook = lambda *_: None
        raise KeyboardInterrupt  # Python ends by the signal, after its clean-up
    if code < 0:
        signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    sys.exit(code)
