"""What composed programs write, through real pipes, as the launcher reads it."""

from __future__ import annotations

import fcntl
import os
import select
import threading
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, TextIO

import pytest

from launcher.ros.composed import current, member_output
from launcher.ros.composed.member_output import MemberStream
from launcher.run.compose.group_output import GroupOutput

LINES = 500
PIECES = 10000
LONGEST = 3 * select.PIPE_BUF


class Member:
    """As far as a stream has to do with it."""

    def __init__(self, index: int) -> None:
        self.index = index


class Pipe:
    """A stream of a composed process, and what the launcher makes of it."""

    def __init__(self, members: int) -> None:
        self.reader, self.writer = os.pipe()
        self.file: TextIO = open(self.writer, "w")  # noqa: SIM115  (as long as this)
        self.stream = MemberStream(self.file)
        names = [(f"m-{index}", b"") for index in range(members)]
        self.group = GroupOutput(("group", b""), names, lambda index, code: None)
        self.buffer = self.group.buffer()
        self.group.take(b"token " + member_output._TOKEN)
        self.lines: dict[str, bytes] = {}

    def write(self, index: int, *texts: str) -> None:
        one: Any = Member(index)
        with current.acting_as(one):
            for text in texts:
                self.stream.write(text)
        self.stream.finish(index)

    def run(self, *writers: Callable[[], object]) -> None:
        """Let them all write at the same time, and read to the end."""
        threads = [threading.Thread(target=writer) for writer in writers]
        reading = threading.Thread(target=self._read)
        for thread in (reading, *threads):
            thread.start()
        for thread in threads:
            thread.join()
        self.file.close()
        reading.join()

    def _read(self) -> None:
        while chunk := os.read(self.reader, 65536):
            self._take(self.buffer.feed(chunk)[0])
        self._take(self.buffer.take_partial()[0])

    def _take(self, lines: bytes) -> None:
        for part in self.group.parts(lines, self.buffer.mark) if lines else ():
            self.lines[part.name] = self.lines.get(part.name, b"") + part.lines


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    one = Pipe(4)
    yield one
    one.file.close()
    os.close(one.reader)


def lengths(index: int) -> list[int]:
    return [(number * 37 * (index + 1)) % LONGEST for number in range(LINES)]


@pytest.mark.parametrize("is_blocking", [True, False])
def test_lines_of_many_threads_are_whole_whatever_is_written_between(pipe: Pipe, is_blocking: bool):
    if not is_blocking:  # a child of a node may do that to the pipe that all share
        flags = fcntl.fcntl(pipe.writer, fcntl.F_GETFL)
        fcntl.fcntl(pipe.writer, fcntl.F_SETFL, flags | os.O_NONBLOCK)
    own = {index: [f"{index}:{'x' * length}\n" for length in lengths(index)] for index in range(4)}

    def write_pieces() -> None:
        for number in range(PIECES):
            for piece in (b"<%d " % number, b"in pieces", b">\n"):
                member_output.write_all(pipe.writer, piece)

    pipe.run(write_pieces, *(partial(pipe.write, index, *own[index]) for index in own))
    for index, lines in own.items():
        assert pipe.lines[f"m-{index}"].decode() == "".join(lines)
    assert pipe.lines["group"] == b"".join(b"<%d in pieces>\n" % n for n in range(PIECES))


def test_a_line_may_be_written_in_parts_and_have_no_end(pipe: Pipe):
    pipe.run(partial(pipe.write, 1, "a", "b\nc", "é" * LONGEST, "d"))
    assert pipe.lines == {"m-1": f"ab\nc{'é' * LONGEST}d\n".encode()}
