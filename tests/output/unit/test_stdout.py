"""Lines that are collected and written together, and a terminal that takes a little at a time."""

from __future__ import annotations

import os
import pty
import select
import tty
from collections.abc import Iterator

import pytest

from launcher.output import output_queue
from launcher.output.output_queue import TERMINAL_HIGH_WATER, TOGETHER_BYTES
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from tests.support.waiting import wait_until


class Screen(StdoutWriter):
    """Notes its blocks instead of writing them."""

    blocks: list[bytes]

    def _try(self, block: bytes) -> bytes:
        self.blocks.append(bytes(block))
        return b""


@pytest.fixture
def screen() -> Iterator[Screen]:
    read_end, write_end = os.pipe()
    with Reactor() as reactor:
        made = Screen(reactor, write_end, colour=False)
        made.blocks = []
        yield made
        made.finish()
    os.close(read_end)
    os.close(write_end)


def test_lines_are_written_together_in_their_order(screen: Screen):
    with screen.collecting():
        screen.log("INFO", "a", "one")
        screen.write_lines("b", b"[b] ", b"two\n")
        assert screen.blocks == []
    assert screen.blocks == [b"[INFO] [a]: one\n[b] two\n"]
    screen.log("INFO", "a", "three")
    assert screen.blocks[1:] == [b"[INFO] [a]: three\n"]


def test_lines_are_not_collected_for_long(screen: Screen, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(output_queue, "COLLECT_S", -1.0)
    with screen.collecting():
        screen.log("INFO", "a", "one")
        assert screen.blocks == [b"[INFO] [a]: one\n"]
        screen.log("INFO", "a", "two")
    assert screen.blocks[1:] == [b"[INFO] [a]: two\n"]


def test_an_exception_loses_no_line(screen: Screen):
    with pytest.raises(KeyError), screen.collecting():
        screen.log("INFO", "a", "one")
        raise KeyError
    assert screen.blocks == [b"[INFO] [a]: one\n"]


class Terminal:
    """A pseudo-terminal, and a writer to it whose event loop never turns."""

    def __init__(self, reactor: Reactor) -> None:
        self.fd, theirs = pty.openpty()
        tty.setraw(theirs)
        self.screen = StdoutWriter(reactor, theirs, colour=False)
        self.reactor = reactor
        self._theirs = theirs

    def read(self) -> bytes:
        return os.read(self.fd, 1 << 20)

    def fill(self) -> None:
        """Write until it takes nothing more."""
        self.screen.write(b"a" * 4 * TOGETHER_BYTES)
        assert self.screen.waiting_bytes > 0

    def empty(self) -> None:
        """Read, and let the writer push, until nothing waits."""
        while self.screen.waiting_bytes:
            self.read()
            self.screen.push()

    def close(self) -> None:
        self.screen.take_waiting()
        self.screen.finish()
        os.close(self._theirs)
        os.close(self.fd)


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    with Reactor() as reactor:
        made = Terminal(reactor)
        yield made
        made.close()


def test_a_terminal_gets_more_with_each_block_that_is_queued(terminal: Terminal):
    expected = b"".join(b"%07d\n" % number for number in range(20_000))
    screen = terminal.screen
    screen.write(expected)
    assert screen.waiting_bytes > 0
    found = b""
    while len(found) < len(expected):
        found += terminal.read()
        screen.push()  # no turn of the loop
    assert found == expected
    assert screen.waiting_bytes == 0


def test_short_blocks_are_written_together_in_their_order(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
):
    screen = terminal.screen
    terminal.fill()
    blocks = [b"%07d\n" % number for number in range(10_000)]
    for block in blocks:
        screen.write(block)
    sizes: list[int] = []
    write = os.write

    def noted(fd: int, block: bytes) -> int:
        sizes.append(len(block))
        return write(fd, block)

    monkeypatch.setattr(os, "write", noted)
    size = screen.waiting_bytes
    found = b""
    while screen.waiting_bytes:
        found += terminal.read()
        screen.push()
    assert len(sizes) < size / 1000
    monkeypatch.undo()
    while not found.endswith(blocks[-1]):
        found += terminal.read()
    assert found.lstrip(b"a") == b"".join(blocks)


def test_a_queue_that_was_emptied_between_two_turns_may_fill_again(terminal: Terminal):
    pressed: list[bool] = []
    terminal.screen.on_pressure = pressed.append
    for _ in range(3):
        terminal.fill()
        terminal.screen.write(b"b" * TERMINAL_HIGH_WATER)
        terminal.empty()
    assert pressed == [True]

    def is_released() -> bool:
        """The kernel moves what was written to the reader, and then has room, in its own time."""
        if select.select([terminal.fd], [], [], 0)[0]:
            terminal.read()
        terminal.reactor.turn()
        return pressed == [True, False]

    wait_until(is_released, "room in the terminal")
    assert terminal.reactor.timeout_s() is None


def test_a_terminal_is_not_watched_any_more_after_its_output_was_diverted(terminal: Terminal):
    diverted: list[int] = []
    terminal.fill()
    terminal.empty()
    terminal.read()
    read_end, write_end = os.pipe()
    terminal.screen.divert(write_end, lambda: diverted.append(1))
    assert diverted == [1]
    with pytest.raises(FileNotFoundError):
        terminal.reactor._epoll.unregister(terminal.screen._terminal)
    terminal.screen.come_back(b"")
    os.close(read_end)
    os.close(write_end)
