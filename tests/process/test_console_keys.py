"""What a person types into the console, and what each key does."""

from __future__ import annotations

import itertools
import threading

import pytest

from tests.process.conftest import Bench
from tests.support.console_runs import TICKS


def test_ctrl_d_on_an_empty_line_ends_the_run(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type("xy\x02\x04")  # back over the y, and delete it
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> x", "one letter")
    glass.type("\x15\x04")
    assert glass.exit_code() == 0
    assert any("> quit" in row for row in glass.scrolled)


STUBBORN = """
        py("import signal, time\\ndef refuse(*_): print('no', flush=True)\\n"
           "for s in (2, 15): signal.signal(s, refuse)\\n"
           "print('up', flush=True)\\nwhile True: time.sleep(1)", name="stubborn",
           sigterm_timeout="600", sigkill_timeout="600"),
"""


def test_a_second_and_a_third_ctrl_c_do_not_wait(bench: Bench):
    glass = bench.glass(STUBBORN)
    glass.wait_for_prompt()
    glass.wait_for("] up")
    glass.ctrl_c()
    glass.wait_until(lambda: glass.text.count("] no") == 1, "the answer to SIGINT")
    glass.ctrl_c()
    glass.wait_until(lambda: glass.text.count("] no") == 2, "the answer to SIGTERM")
    glass.ctrl_c()
    assert glass.exit_code() == 130
    assert sum("not waiting any longer" in row for row in glass.scrolled) == 2


def test_lines_typed_before_come_back_in_the_next_run(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("mute robot_2")
    glass.wait_for("robot_2-2 is muted; its log files continue")
    glass.enter("quit")
    assert glass.exit_code() == 0
    again = bench.glass(TICKS)
    again.wait_for_prompt()
    again.type("\x1b[A\x1b[A")
    again.wait_until(lambda: again.rows[again.prompt_row] == "> mute robot_2", "the line")
    again.ctrl_c()
    assert again.exit_code() == 0


@pytest.mark.thorough
def test_ctrl_r_finds_a_line_and_enter_runs_it(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("mute robot_2")
    glass.wait_for("> mute robot_2", "robot_2-2 is muted")
    glass.enter("unmute robot_2")
    glass.wait_for("> unmute robot_2", "robot_2-2 is shown again")
    glass.type("\x12ROBOT")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> unmute robot_2", "the newest")
    glass.type("\x12\x1b[C")  # an older one, and to the end of it
    end = len("> mute robot_2")
    glass.wait_until(lambda: glass.cursor == (glass.prompt_row, end), "the end of the older one")
    glass.type("\x15\x12xyz")
    glass.wait_until(lambda: "no line has: xyz" in glass.rows, "that there is none")
    glass.type("\r")
    glass.wait_until(lambda: "xyz" not in glass.text, "nothing done")
    glass.type("\x12unm\r")  # newer than the one that was emptied
    glass.wait_until(lambda: glass.scrolled.count("> unmute robot_2") == 2, "it is run")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == ">", "an empty line")
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
def test_the_prompt_sign_returns_after_a_line_that_was_too_long(bench: Bench):
    glass = bench.glass(TICKS, columns=40)
    glass.wait_for_prompt()
    glass.type("x" * 60)
    glass.wait_until(lambda: "x" * 39 in glass.rows, "the end of the line")
    glass.type("\x15")
    glass.wait_until(lambda: ">" in glass.rows, "the sign")
    glass.type("half a li")
    glass.resize(1, 1)
    glass.resize(40, 12)
    glass.wait_until(lambda: "> half a li" in glass.rows, "the sign and the line")
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
def test_each_line_of_a_paste_is_a_line_of_its_own(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type("\x1b[200~mute robot_1\nmute robot_2\r\nsolo mon\x1b[201~")
    glass.wait_for("> mute robot_1", "robot_1-1 is muted", "> mute robot_2", "robot_2-2 is muted")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> solo mon", "the rest")
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
def test_a_paste_of_300_lines_is_answered_line_by_line(bench: Bench):
    glass = bench.glass('py("input()", name="quiet"),')
    glass.wait_for_prompt()
    lines = "".join(f"mute robot_{number}\n" for number in range(300))
    typist = threading.Thread(target=glass.type, args=(f"\x1b[200~{lines}\x1b[201~",))
    typist.start()
    glass.wait_until(lambda: "> mute robot_299" in glass.rows, "the last line", 120.0)
    typist.join()
    answers = [f"| error: unknown process 'robot_{number}'" for number in range(300)]
    glass.wait_until(lambda: set(answers) <= set(glass.scrolled), "all answers")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == ">", "the prompt")
    rows = [row for row in glass.scrolled if row.startswith(("> mute", "| error"))]
    echoes = [f"> mute robot_{number}" for number in range(300)]
    assert [row for row in rows if row.startswith(">")] == echoes
    assert sorted(row for row in rows if row.startswith("|")) == sorted(answers)
    # A slow answer may come below the next line.
    assert all(map(lambda one, other: rows.index(one) < rows.index(other), echoes, answers))
    glass.ctrl_c()
    glass.exit_code()


@pytest.mark.thorough
def test_lines_typed_ahead_are_answered_in_their_order(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type("solo monitor\rmute robot_1\rbogus\runmute\rgrep tock robot_2\r")
    expected = [
        "> solo monitor",
        "monitor-3 is shown alone",
        "> mute robot_1",
        "robot_1-1 is muted",
        "> bogus",
        "unknown verb 'bogus'",
        "> unmute",
        "> grep tock robot_2",
        "robot_2-2 shows",
    ]
    glass.wait_for(*expected)
    rows = glass.scrolled
    place = {text: next(n for n, row in enumerate(rows) if text in row) for text in expected}
    echoes = [place[text] for text in expected if text.startswith(">")]
    assert echoes == sorted(echoes), "\n".join(rows)
    for echo, answer in itertools.pairwise(expected):  # a slow one may come below the next line
        assert answer.startswith(">") or place[echo] < place[answer], "\n".join(rows)
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
@pytest.mark.parametrize("typed", [b"\xff\r", b"caf\xe9\r", b"\xff\xfe\x00\r", b"\x00\r"], ids=repr)
def test_undecodable_input_leaves_the_console_unchanged(bench: Bench, typed: bytes):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type_bytes(typed)
    glass.enter("mute robot_1")
    glass.wait_for("> mute robot_1", "robot_1-1 is muted")
    glass.ctrl_c()
    assert glass.exit_code() == 0


FLOOD = """
        py("while True: print('x' * 100)", name="flood"),
"""


@pytest.mark.thorough
def test_a_flood_on_a_slow_terminal_can_be_muted(bench: Bench):
    glass = bench.glass(FLOOD)
    glass.bytes_per_s, glass.emulates = 400_000, False
    glass.wait_until(lambda: b"\x1b[?2004h" in glass.raw, "the prompt", 60.0)
    glass.enter("mute flood")
    begun = len(glass.raw)
    glass.wait_until(lambda: b"flood-1 is muted" in glass.raw[begun:], "the answer", 60.0)
    assert len(glass.raw) - begun < 10_000_000  # what was on its way, and no more
    glass.bytes_per_s = None
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
def test_an_unwritable_history_is_kept_in_memory(bench: Bench):
    bench.env["XDG_STATE_HOME"] = "/proc/none"
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("mute robot_2")
    glass.wait_for("robot_2-2 is muted")
    glass.type("\x1b[A")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> mute robot_2", "the line")
    glass.ctrl_c()
    assert glass.exit_code() == 0


def test_what_is_typed_before_there_is_a_prompt_is_not_lost(bench: Bench):
    glass = bench.glass(TICKS)
    glass.type("ps")
    glass.wait_until(lambda: "> ps" in glass.text, "it behind the prompt")
    glass.ctrl_c()
    assert glass.exit_code() == 0
