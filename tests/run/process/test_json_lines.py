"""Helper processes that speak lines of JSON, with real ones."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

from launcher.posix.reactor import Reactor
from launcher.run.helpers.json_lines import JsonLinesProcess

ECHO = """
import sys
print("Fast DDS prints this", flush=True)
for line in sys.stdin:
    sys.stdout.write(line)
    sys.stdout.flush()
"""
DEAF = "import time; print(1, flush=True); time.sleep(1000)"
FAILING = "import sys; sys.exit('this is why')"


class Talk:
    """A helper process, what it has said, and how it has ended."""

    def __init__(self, folder: Path, program: str) -> None:
        (folder / "talk_program.py").write_text(program, encoding="utf-8")
        self._reactor = Reactor()
        self.messages: list[Any] = []
        self.ends: list[tuple[int, str]] = []
        self.process = JsonLinesProcess(
            self._reactor,
            "talk_program",
            {**os.environ, "PYTHONPATH": str(folder)},
            on_message=self.messages.append,
            on_end=lambda code, line: self.ends.append((code, line)),
        )

    def turn_until(self, fact: Callable[[], object]) -> None:
        """Serve until the fact holds; AssertionError after a minute."""
        deadline = time.monotonic() + 60.0
        while not fact():
            assert time.monotonic() < deadline
            self._reactor.turn()

    def close(self) -> None:
        self.process.close()
        self._reactor.close()


@pytest.fixture
def talks(tmp_path: Path) -> Iterator[Any]:
    made: list[Talk] = []

    def talk(program: str) -> Talk:
        made.append(Talk(tmp_path, program))
        return made[-1]

    yield talk
    for one in made:
        one.close()


def test_messages_go_both_ways_and_other_lines_are_skipped(talks):
    talk = talks(ECHO)
    large = {"text": "x" * 1_000_000}  # more than a pipe takes
    talk.process.send(large)
    talk.process.send([None, 1.5])

    talk.turn_until(lambda: len(talk.messages) == 2)
    assert talk.messages == [large, [None, 1.5]]


def test_one_that_does_not_read_does_not_keep_the_run_waiting(talks):
    talk = talks(DEAF)
    talk.turn_until(lambda: talk.messages)

    talk.process.send("x" * 1_000_000)
    assert talk.process.has_unsent
    talk.process.close()

    assert not psutil.pid_exists(talk.process.pid)
    assert talk.ends == []  # it was ended by us


def test_its_end_is_reported_once_with_its_last_line(talks):
    talk = talks(FAILING)
    talk.turn_until(lambda: talk.ends)

    assert talk.ends == [(1, "this is why")]
    assert talk.process.has_ended
    talk.process.send("nobody reads this")
    assert not talk.process.has_unsent


def test_it_ends_by_itself_with_its_input(talks):
    talk = talks(ECHO)
    talk.process.send(1)
    talk.turn_until(lambda: talk.messages)
    talk.process.close_input()
    talk.turn_until(lambda: talk.ends)

    assert talk.ends == [(0, "")]
