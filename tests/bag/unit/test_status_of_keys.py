"""The line of status on a terminal whose control characters are escaped."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator

import pytest

from launcher.bag.ros.keys_and_status import StatusLine
from launcher.ros.verb import escaped_output


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch) -> _Terminal:
    """A terminal, for `shown_on`."""
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.delenv("TERM", raising=False)
    return _Terminal()


@contextlib.contextmanager
def shown_on(terminal: _Terminal) -> Iterator[None]:
    with contextlib.redirect_stderr(terminal), escaped_output():
        yield


def test_only_the_control_characters_of_the_line_itself_reach_the_terminal(terminal: _Terminal):
    with shown_on(terminal):
        status = StatusLine(lambda width: "a \x1b[2J")
        status.draw(now=True)
        status.print("b \r\x1b]0;c\x07")
        status.close()
    shown = "\ra \\x1b[2J\x1b[K"
    assert terminal.getvalue() == f"{shown}\r\x1b[Kb \\x0d\\x1b]0;c\\x07\n{shown}\r\x1b[K"


def test_a_line_after_the_end_stays_alone(terminal: _Terminal):
    with shown_on(terminal):
        status = StatusLine(lambda width: "going on")
        status.close()
        status.print("done")
        status.draw(now=True)
    assert terminal.getvalue() == "done\n"


def test_a_dumb_terminal_gets_whole_lines_alone(terminal: _Terminal, monkeypatch):
    monkeypatch.setenv("TERM", "dumb")
    with shown_on(terminal):
        status = StatusLine(lambda width: "going on")
        status.draw(now=True)
        status.print("done")
    assert terminal.getvalue() == "done\n"


class _Full(_Terminal):
    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")


def test_a_stderr_that_takes_nothing_does_not_end_a_recording(monkeypatch):
    monkeypatch.delenv("TERM", raising=False)
    with shown_on(_Full()):
        status = StatusLine(lambda width: "going on")
        status.draw(now=True)
        status.print("done")
        status.close()
