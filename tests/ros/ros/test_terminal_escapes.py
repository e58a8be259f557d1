"""Escape sequences in messages do not reach a terminal; pipes get the raw text."""

from __future__ import annotations

import sys

import pytest

from launcher.base.text import escape_controls
from tests.support.terminal import Terminal
from tests.support.verbs import going_on, launcher

pytestmark = pytest.mark.thorough

LAUNCHER = (sys.executable, "-m", "launcher")
EVIL = "\x1b]0;owned\x07\x9b2J\r\tgood\x7f"
SHOWN = "\\x1b]0;owned\\x07\\x9b2J\\x0d\tgood\\x7f"


def test_line_ends_tabs_and_letters_stay():
    assert escape_controls(EVIL) == SHOWN
    assert escape_controls("ä\n\t漢\u3000🤖") == "ä\n\t漢\u3000🤖"


@pytest.fixture
def evil(verb):
    """A parameter with commands to a terminal for its value."""
    assert verb("param", "set", "/talker", "name", EVIL).code == 0
    yield ("param", "get", "/talker", "name", "--hide-type", "--spin-time", "60")
    assert verb("param", "set", "/talker", "name", "sample").code == 0


def test_a_value_is_escaped_on_a_terminal_and_unchanged_in_a_pipe(env, evil):
    assert launcher(env, *evil).out == EVIL.replace("\r", "\n") + "\n"  # read as text
    with Terminal([*LAUNCHER, *evil], env=env) as terminal:
        assert terminal.exit_code() == 0
        assert "\x1b" not in terminal.raw
        assert SHOWN.replace("\t", " ") in terminal.text.expandtabs(1)


@pytest.mark.parametrize("shape", [["--field", "data"], ["--csv"], ["--json"], []], ids=str)
def test_a_message_is_escaped_on_a_terminal(env, shape):
    topic = ("/evil", "std_msgs/msg/String")
    data = 'data: "' + EVIL.encode("unicode_escape").decode() + '"'
    with (
        going_on(env, "topic", "pub", *topic, data, "-r", "20", "-w", "0"),
        Terminal([*LAUNCHER, "topic", "echo", *topic, "--once", *shape], env=env) as terminal,
    ):
        assert terminal.exit_code() == 0
        (line,) = [line for line in terminal.raw.split("\n") if "owned" in line]
        assert not set("\x1b\x07\x9b\x7f") & set(line)
