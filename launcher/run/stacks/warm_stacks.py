"""Stacks that a node writes itself, without py-spy: one that was started warm."""

from __future__ import annotations

import contextlib
import functools
import os
import re
from collections.abc import Callable

from launcher.posix import proc
from launcher.posix.reactor import Reactor
from launcher.run.stacks.dump import Dump, StackFrame, Thread, command_of
from launcher.run.warm.stack_answer import FILE

ANSWER_S = 1.0  # it takes milliseconds, unless C code holds the GIL
LOOK_S = 0.005
MOST_BYTES = 1024 * 1024  # of old answers
_PIPE = re.compile(r"pipe:\[\d+\]")


def ask(reactor: Reactor, pid: int, done: Callable[[Dump | None], None]) -> bool:
    """Call `done` with the stacks of this process, or with None if it does not answer in time.

    False if it cannot be asked: it was started cold, is suspended, or belongs to somebody else.
    """
    if proc.is_suspended(pid):
        return False
    try:
        file, requests = _open(pid)
    except OSError:
        return False
    try:
        size = os.fstat(file).st_size
        if size > MOST_BYTES:
            os.ftruncate(file, 0)
            size = 0
        os.write(requests, b"?")
    except OSError:
        os.close(file)
        return False
    finally:
        os.close(requests)
    _look(reactor, pid, file, size, reactor.now() + ANSWER_S, done)
    return True


def _open(pid: int) -> tuple[int, int]:
    """The file of its answers, and the pipe for requests, which has the next descriptor."""
    folder = f"{proc.ROOT}/{proc.living_thread(pid)}/fd"
    for name in os.listdir(folder):
        link = pipe = ""
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            link = os.readlink(f"{folder}/{name}")
        if link != f"/memfd:{FILE} (deleted)":
            continue
        with contextlib.suppress(FileNotFoundError):
            pipe = os.readlink(f"{folder}/{int(name) + 1}")
        if _PIPE.fullmatch(pipe):
            requests = os.open(
                f"{folder}/{int(name) + 1}", os.O_WRONLY | os.O_NONBLOCK | os.O_CLOEXEC
            )
            try:
                return os.open(f"{folder}/{name}", os.O_RDWR | os.O_CLOEXEC), requests
            except OSError:
                os.close(requests)
                raise
    raise FileNotFoundError(FILE)


def _look(
    reactor: Reactor,
    pid: int,
    file: int,
    begin: int,
    until_s: float,
    done: Callable[[Dump | None], None],
) -> None:
    text = os.pread(file, MOST_BYTES, begin).decode(errors="replace")
    dump = parse(pid, text)
    if dump is None and reactor.now() < until_s and proc.is_alive(pid):
        again = functools.partial(_look, reactor, pid, file, begin, until_s, done)
        reactor.call_later(LOOK_S, again)
        return
    os.close(file)
    done(dump)


def parse(pid: int, text: str) -> Dump | None:
    """The first answer of this process in a text; None if there is no complete one.

    One with another pid is that of a process that has forked this one.
    """
    _, begin, rest = text.partition(f"pid {pid}\n")
    answer, end, _ = rest.partition(f"end {pid}\n")
    if not (begin and end):
        return None
    threads: list[tuple[int, str, list[StackFrame]]] = []
    for line in answer.splitlines():
        word, _, more = line.partition(" ")
        if word == "thread":
            tid, _, name = more.partition(" ")
            threads.append((int(tid), name, []))
        elif word.isdigit() and threads:
            function, _, path = more.partition("\0")
            threads[-1][2].append(StackFrame(function, path, int(word)))
    threads.sort(key=lambda thread: (thread[0] != pid, thread[0]))
    found = (
        Thread(tid, name, proc.describe_state(tid) if tid else "-", tuple(frames))
        for tid, name, frames in threads
    )
    return Dump(pid, command_of(pid), tuple(found))
