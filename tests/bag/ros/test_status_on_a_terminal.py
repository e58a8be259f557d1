"""What `bag record` and `bag play` write on a terminal: one line of status, gone at the end."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.bags import counting, write_bag
from tests.support.ros_domain import ros_domain, talking
from tests.support.screen_terminal import ScreenTerminal

PROMPT = "$ at the prompt"
COLUMNS = 300  # the path of a bag is long, and must not break a row


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path / "log") as env:
        yield env


def in_a_shell(env: dict[str, str], words: str, **more: str) -> ScreenTerminal:
    """A shell that runs `launcher bag WORDS` and then writes its prompt."""
    script = f"trap : INT; {sys.executable} -m launcher bag {words}; printf '{PROMPT}'"
    environment = {**env, "TERM": "xterm-256color", **more}
    return ScreenTerminal(["sh", "-c", script], env=environment, columns=COLUMNS)


def ended(terminal: ScreenTerminal) -> list[str]:
    """What is on the screen at the end; the prompt has a line to itself."""
    assert terminal.exit_code() == 0
    assert b"\\x" not in terminal.raw  # no control character as text
    shown = [row for row in terminal.rows if row and row != "^C"]
    assert shown.pop() == PROMPT
    return shown


@pytest.mark.thorough
def test_the_status_of_a_recording_is_one_line_that_goes_away(domain, tmp_path: Path):
    folder = tmp_path / "bag"
    with (
        talking(domain, "tests.support.bag_talker", "/bag/text"),
        in_a_shell(domain, f"record -o {folder} /bag/text") as terminal,
    ):
        terminal.wait_for("recording  0:01", "1 topic")
        (row,) = [row for row in terminal.rows if "0 lost" in row]
        assert row.startswith("recording  0:0")
        terminal.ctrl_c()
        first, last = ended(terminal)
    assert first == f"recording into {folder} (space pauses)"
    assert "1 topic" in last
    assert last.startswith("wrote ")


@pytest.mark.thorough
def test_the_status_of_a_playing_is_one_line_that_goes_away(domain, tmp_path: Path):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 12))
    with in_a_shell(domain, f"play {bag}") as terminal:
        terminal.wait_for("playing [")
        first, last = ended(terminal)
        assert terminal.raw.index(b"waiting [  ") < terminal.raw.index(b"playing [")
        assert b"waiting [=" not in terminal.raw
    assert first.startswith("playing 1 topic (space pauses")
    assert last == "played 12 messages"


@pytest.mark.thorough
def test_a_terminal_that_cannot_rewrite_a_line_gets_lines_alone(domain, tmp_path: Path):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 12))
    with in_a_shell(domain, f"play {bag}", TERM="dumb") as terminal:
        first, last = ended(terminal)
        assert b"\x1b" not in terminal.raw
    assert first.startswith("playing 1 topic (space pauses")
    assert last == "played 12 messages"


@pytest.mark.thorough
@pytest.mark.parametrize(("rate", "is_drawn"), [("0", False), ("-1", True), ("10", True)])
def test_how_often_the_status_is_drawn(domain, tmp_path: Path, rate: str, is_drawn: bool):
    bag = write_bag(tmp_path / "bag", counting("/chatter", 12))
    words = f"play {bag} --progress-bar-update-rate {rate} --progress-bar-separation-lines 1"
    with in_a_shell(domain, words) as terminal:
        _, last = ended(terminal)
        assert (b"playing [" in terminal.raw) == is_drawn
    assert last == "played 12 messages"
