"""The console in a real terminal, looked at through a terminal emulator."""

from __future__ import annotations

import re

import pytest

from tests.process.conftest import Bench
from tests.support.console_runs import TICKS


def test_a_process_is_killed_and_started_again_while_lines_flow(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.wait_for("robot_1-1] tick")
    glass.enter("kill robot_2")
    glass.wait_for("> kill robot_2", "| robot_2-2 stopped in ", "[robot_2-2]: process was stopped")
    glass.wait_until(lambda: "robot_2 stopped" in glass.text, "the bar tells")
    glass.enter("start robot_2")
    glass.wait_for("robot_2-2 started with pid ")
    glass.wait_until(lambda: "robot_2 stopped" not in glass.text, "the bar tells")
    glass.ctrl_c()
    assert glass.exit_code() == 0, glass.text


def test_an_answer_is_shown_below_the_output_it_caused(bench: Bench):
    glass = bench.glass('py("input()", name="one"), py("input()", name="other"),')
    glass.wait_for_prompt()
    glass.enter("kill one")
    glass.wait_for("| one-1 stopped in ", "[one-1]: process was stopped")
    told = [row[:6] for row in glass.scrolled if "stopped" in row and "one-1" in row]
    assert told == ["[INFO]", "| one-"]
    glass.ctrl_c()
    glass.exit_code()


def test_the_terminal_is_restored_at_the_end_and_the_footer_is_gone(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    assert glass.settings() != glass.untouched
    glass.enter("quit")
    assert glass.exit_code() == 0
    assert glass.settings() == glass.untouched
    assert not glass.cursor_is_hidden
    assert glass.prompt_row == -1 or glass.rows[glass.prompt_row] == "> quit"
    assert "Ctrl-C stops the run" not in glass.text
    assert bench.survivors() == []


def test_the_console_leaves_scrollback_and_mouse_to_the_terminal(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("top")
    glass.wait_until(lambda: "any other key ends this" in glass.text, "the table")
    glass.ctrl_c()
    glass.wait_until(lambda: "any other key ends this" not in glass.text, "the end of it")
    glass.ctrl_c()
    assert glass.exit_code() == 0
    modes = {int(mode) for mode in re.findall(rb"\x1b\[\?(\d+)h", glass.raw)}
    assert modes <= {7, 12, 25, 2004}  # wrapping, cursor, pastes; no other screen, no mouse
    assert any("process started with pid" in row for row in glass.scrolled)


@pytest.mark.thorough
def test_ctrl_backslash_stops_the_run_as_it_does_in_any_terminal(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type("\x1c")
    assert glass.exit_code() == 0
    assert any("user interrupted with SIGQUIT" in row for row in glass.scrolled)


def test_tab_completes_verbs_names_and_signals(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type("res\t")
    glass.wait_until(lambda: "restart  resume" in glass.text, "what there is")
    glass.type("\t\t")
    glass.wait_until(lambda: "resume suspended processes (SIGCONT)" in glass.rows, "what it is")
    glass.type("\x15kill mo\t")
    glass.wait_until(lambda: "> kill monitor" in glass.text, "the whole name")
    glass.type("\x15kill -s SIGTE\t")
    glass.wait_until(lambda: "> kill -s SIGTERM" in glass.text, "the whole signal")
    glass.type("\x15stop rob\t")
    glass.wait_until(lambda: "robot_1  robot_2  robot_*" in glass.text, "names and the glob")
    glass.type("*\t")
    glass.wait_until(lambda: "> stop robot_1-1 robot_2-2" in glass.text, "what it stands for")
    glass.ctrl_c()
    assert glass.exit_code() == 0


def test_a_misspelt_verb_or_name_gets_a_suggestion(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("kil robot_2")
    glass.wait_for("error: unknown verb 'kil'", "hint: did you mean 'kill'?")
    glass.enter("kill robo_2")
    glass.wait_for("unknown process 'robo_2'")
    glass.ctrl_c()
    assert glass.exit_code() == 0


BURST = """
        py("input()\\nfor n in range(10000): print(f'line {n:05} ' + 'x' * 40)\\ninput()",
           name="burst"),
"""


@pytest.mark.thorough
def test_a_burst_of_10_000_lines_stays_whole_and_in_order_above_the_prompt(bench: Bench):
    glass = bench.glass(BURST)
    glass.wait_for_prompt()
    glass.enter("send burst go")
    glass.type("half a li")
    glass.wait_until(lambda: "line 09999" in glass.text, "the last line", 60.0)
    glass.wait_until(lambda: "> half a li" in glass.text, "what is typed")
    glass.wait_until(
        lambda: glass.cursor == (glass.prompt_row, len("> half a li")), "the cursor behind it"
    )
    glass.wait_until(lambda: not any(glass.rows[glass.prompt_row + 3 :]), "nothing below the bar")
    shown = [line for line in glass.scrolled if "] line " in line]
    assert shown == [f"[burst-1] line {n:05} {'x' * 40}" for n in range(10000)]
    glass.ctrl_c()
    glass.exit_code()
