"""What a person types into the console, and what each key does."""

from __future__ import annotations

import itertools
import threading

import pytest

from tests.support.benches import Bench
from tests.support.console_runs import TICKS


def test_ctrl_d_on_an_empty_line_ends_the_run(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type("xy\x02\x04")  # back over the y, and delete it
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == "> x", "one letter")
    terminal.type("\x15\x04")
    assert terminal.exit_code() == 0
    assert any("> quit" in row for row in terminal.scrolled)


STUBBORN = """
        py("import signal, time\\ndef refuse(*_): print('no', flush=True)\\n"
           "for s in (2, 15): signal.signal(s, refuse)\\n"
           "print('up', flush=True)\\nwhile True: time.sleep(1)", name="stubborn",
           sigterm_timeout="600", sigkill_timeout="600"),
"""


def test_a_second_and_a_third_ctrl_c_do_not_wait(bench: Bench):
    terminal = bench.screen_terminal(STUBBORN)
    terminal.wait_for_prompt()
    terminal.wait_for("] up")
    terminal.ctrl_c()
    terminal.wait_until(lambda: terminal.text.count("] no") == 1, "the answer to SIGINT")
    terminal.ctrl_c()
    terminal.wait_until(lambda: terminal.text.count("] no") == 2, "the answer to SIGTERM")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130
    assert sum("not waiting any longer" in row for row in terminal.scrolled) == 2


def test_lines_typed_before_come_back_in_the_next_run(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("mute robot_2")
    terminal.wait_for("robot_2-2 is muted; its log files continue")
    terminal.enter("quit")
    assert terminal.exit_code() == 0
    again = bench.screen_terminal(TICKS)
    again.wait_for_prompt()
    again.type("\x1b[A\x1b[A")
    again.wait_until(lambda: again.rows[again.prompt_row] == "> mute robot_2", "the line")
    again.ctrl_c()
    assert again.exit_code() == 0


@pytest.mark.thorough
def test_w_prints_the_link_of_the_page_which_ends_with_the_run(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("w")
    terminal.wait_for("[launch]: page: http://127.0.0.1:")
    terminal.wait_for("| http://127.0.0.1:")  # the answer to the verb
    terminal.enter("web")
    terminal.wait_until(
        lambda: sum("| http://127.0.0.1:" in row for row in terminal.scrolled) == 2, "it again"
    )
    assert sum("[launch]: page: http://" in row for row in terminal.scrolled) == 1
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_ctrl_r_finds_a_line_and_enter_runs_it(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("mute robot_2")
    terminal.wait_for("> mute robot_2", "robot_2-2 is muted")
    terminal.enter("unmute robot_2")
    terminal.wait_for("> unmute robot_2", "robot_2-2 is shown again")
    terminal.type("\x12ROBOT")
    terminal.wait_until(
        lambda: terminal.rows[terminal.prompt_row] == "> unmute robot_2", "the newest"
    )
    bench.ask_run(terminal.pid, "pause", "robot_*")  # for each line, all is drawn again
    terminal.type("\x12\x1b[C")  # an older one, and to the end of it
    end = len("> mute robot_2")
    terminal.wait_until(
        lambda: terminal.cursor == (terminal.prompt_row, end), "the end of the older one"
    )
    terminal.type("\x15\x12xyz")
    terminal.wait_until(lambda: "no line has: xyz" in terminal.rows, "that there is none")
    terminal.type("\r")
    terminal.wait_until(lambda: "xyz" not in terminal.text, "nothing done")
    terminal.type("\x12unm\r")  # newer than the one that was emptied
    terminal.wait_until(lambda: terminal.scrolled.count("> unmute robot_2") == 2, "it is run")
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == ">", "an empty line")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_the_prompt_sign_returns_after_a_line_that_was_too_long(bench: Bench):
    terminal = bench.screen_terminal(TICKS, columns=40)
    terminal.wait_for_prompt()
    terminal.type("x" * 60)
    terminal.wait_until(lambda: "x" * 39 in terminal.rows, "the end of the line")
    terminal.type("\x15")
    terminal.wait_until(lambda: ">" in terminal.rows, "the sign")
    terminal.type("half a li")
    terminal.resize(1, 1)
    terminal.resize(40, 12)
    terminal.wait_until(lambda: "> half a li" in terminal.rows, "the sign and the line")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_each_line_of_a_paste_is_a_line_of_its_own(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type("\x1b[200~mute robot_1\nmute robot_2\r\nsolo mon\x1b[201~")
    terminal.wait_for(
        "> mute robot_1", "robot_1-1 is muted", "> mute robot_2", "robot_2-2 is muted"
    )
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == "> solo mon", "the rest")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_a_paste_of_300_lines_is_answered_line_by_line(bench: Bench):
    terminal = bench.screen_terminal('py("input()", name="quiet"),')
    terminal.wait_for_prompt()
    lines = "".join(f"mute robot_{number}\n" for number in range(300))
    typist = threading.Thread(target=terminal.type, args=(f"\x1b[200~{lines}\x1b[201~",))
    typist.start()
    terminal.wait_until(lambda: "> mute robot_299" in terminal.rows, "the last line", 120.0)
    typist.join()
    answers = [f"| error: unknown process 'robot_{number}'" for number in range(300)]
    terminal.wait_until(lambda: set(answers) <= set(terminal.scrolled), "all answers")
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == ">", "the prompt")
    rows = [row for row in terminal.scrolled if row.startswith(("> mute", "| error"))]
    echoes = [f"> mute robot_{number}" for number in range(300)]
    assert [row for row in rows if row.startswith(">")] == echoes
    assert sorted(row for row in rows if row.startswith("|")) == sorted(answers)
    # A slow answer may come below the next line.
    assert all(map(lambda one, other: rows.index(one) < rows.index(other), echoes, answers))
    terminal.ctrl_c()
    terminal.exit_code()


@pytest.mark.thorough
def test_lines_typed_ahead_are_answered_in_their_order(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type("solo monitor\rmute robot_1\rbogus\runmute\rgrep tock robot_2\r")
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
    terminal.wait_for(*expected)
    rows = terminal.scrolled
    place = {text: next(n for n, row in enumerate(rows) if text in row) for text in expected}
    echoes = [place[text] for text in expected if text.startswith(">")]
    assert echoes == sorted(echoes), "\n".join(rows)
    for echo, answer in itertools.pairwise(expected):  # a slow one may come below the next line
        assert answer.startswith(">") or place[echo] < place[answer], "\n".join(rows)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
@pytest.mark.parametrize("typed", [b"\xff\r", b"caf\xe9\r", b"\xff\xfe\x00\r", b"\x00\r"], ids=repr)
def test_undecodable_input_leaves_the_console_unchanged(bench: Bench, typed: bytes):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type_bytes(typed)
    terminal.enter("mute robot_1")
    terminal.wait_for("> mute robot_1", "robot_1-1 is muted")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


FLOOD = """
        py("while True: print('x' * 100)", name="flood"),
"""


@pytest.mark.thorough
def test_a_flood_on_a_slow_terminal_can_be_muted(bench: Bench):
    terminal = bench.screen_terminal(FLOOD)
    terminal.bytes_per_s, terminal.emulates = 400_000, False
    terminal.wait_until(lambda: b"\x1b[?2004h" in terminal.raw, "the prompt", 60.0)
    terminal.enter("mute flood")
    begun = len(terminal.raw)
    terminal.wait_until(lambda: b"flood-1 is muted" in terminal.raw[begun:], "the answer", 60.0)
    assert len(terminal.raw) - begun < 10_000_000  # what was on its way, and no more
    terminal.bytes_per_s = None
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_an_unwritable_history_is_kept_in_memory(bench: Bench):
    bench.env["XDG_STATE_HOME"] = "/proc/none"
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("mute robot_2")
    terminal.wait_for("robot_2-2 is muted")
    terminal.type("\x1b[A")
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == "> mute robot_2", "the line")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def test_what_is_typed_before_there_is_a_prompt_is_not_lost(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.type("ps")
    terminal.wait_until(lambda: "> ps" in terminal.text, "it behind the prompt")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
