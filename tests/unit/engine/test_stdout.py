"""Lines that are collected, and written together."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from launcher.engine.output import stdout
from launcher.engine.output.stdout import StdoutWriter
from launcher.engine.posix.reactor import Reactor


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
    monkeypatch.setattr(stdout, "COLLECT_S", -1.0)
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
