"""The console in a real terminal, looked at through a terminal emulator."""

from __future__ import annotations

import re

import pytest

from tests.support.benches import Bench
from tests.support.console_runs import TICKS


@pytest.mark.parametrize(
    ("verb", "answer"),
    [("stop", "stopped in "), pytest.param("kill", "ended in ", marks=pytest.mark.thorough)],
    ids=["stop", "kill"],
)
def test_a_process_is_stopped_and_started_again_while_lines_flow(
    bench: Bench, verb: str, answer: str
):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.wait_for("robot_1-1] tick")
    terminal.enter(f"{verb} robot_2")
    terminal.wait_for(
        f"> {verb} robot_2", f"| robot_2-2 {answer}", "[robot_2-2]: process was stopped"
    )
    terminal.wait_until(lambda: "robot_2 stopped" in terminal.text, "the bar tells")
    terminal.enter("start robot_2")
    terminal.wait_for("robot_2-2 started with pid ")
    terminal.wait_until(lambda: "robot_2 stopped" not in terminal.text, "the bar tells")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text


def test_an_answer_is_shown_below_the_output_it_caused(bench: Bench):
    terminal = bench.screen_terminal('py("input()", name="one"), py("input()", name="other"),')
    terminal.wait_for_prompt()
    terminal.enter("stop one")
    terminal.wait_for("| one-1 stopped in ", "[one-1]: process was stopped")
    told = [row[:6] for row in terminal.scrolled if "stopped" in row and "one-1" in row]
    assert told == ["[INFO]", "| one-"]
    terminal.ctrl_c()
    terminal.exit_code()


def test_the_terminal_is_restored_at_the_end_and_the_footer_is_gone(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    assert terminal.settings() != terminal.untouched
    terminal.enter("quit")
    assert terminal.exit_code() == 0
    assert terminal.settings() == terminal.untouched
    assert not terminal.cursor_is_hidden
    assert terminal.prompt_row == -1 or terminal.rows[terminal.prompt_row] == "> quit"
    assert "Ctrl-C stops the run" not in terminal.text
    assert bench.survivors() == []


def test_the_console_leaves_scrollback_and_mouse_to_the_terminal(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("top")
    terminal.wait_until(lambda: "any other key ends this" in terminal.text, "the table")
    terminal.ctrl_c()
    terminal.wait_until(lambda: "any other key ends this" not in terminal.text, "the end of it")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    modes = {int(mode) for mode in re.findall(rb"\x1b\[\?(\d+)h", terminal.raw)}
    assert modes <= {7, 12, 25, 2004}  # wrapping, cursor, pastes; no other screen, no mouse
    assert any("process started with pid" in row for row in terminal.scrolled)


@pytest.mark.thorough
def test_ctrl_backslash_stops_the_run_as_it_does_in_any_terminal(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type("\x1c")
    assert terminal.exit_code() == 0
    assert any("user interrupted with SIGQUIT" in row for row in terminal.scrolled)


def test_clear_clears_the_screen_and_q_stops_the_run(bench: Bench):
    terminal = bench.screen_terminal('sh("echo something; exec sleep 1000", name="sleeper")')
    terminal.wait_for_prompt()
    terminal.wait_for("[sleeper-1] something")
    terminal.enter("clear")
    terminal.wait_until(lambda: "something" not in terminal.text, "an empty screen")
    terminal.enter("q")
    assert terminal.exit_code() == 0


def test_tab_completes_verbs_names_and_signals(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type("res\t")
    terminal.wait_until(lambda: "restart  resume" in terminal.text, "what there is")
    terminal.type("\t\t")
    terminal.wait_until(
        lambda: "resume suspended processes (SIGCONT)" in terminal.rows, "what it is"
    )
    terminal.type("\x15kill mo\t")
    terminal.wait_until(lambda: "> kill monitor" in terminal.text, "the whole name")
    terminal.type("\x15kill -s SIGTE\t")
    terminal.wait_until(lambda: "> kill -s SIGTERM" in terminal.text, "the whole signal")
    terminal.type("\x15stop rob\t")
    terminal.wait_until(lambda: "robot_1  robot_2  robot_*" in terminal.text, "names and the glob")
    terminal.type("*\t")
    terminal.wait_until(lambda: "> stop robot_1-1 robot_2-2" in terminal.text, "what it stands for")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def test_a_misspelt_verb_or_name_gets_a_suggestion(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("kil robot_2")
    terminal.wait_for("error: unknown verb 'kil'", "hint: did you mean 'kill'?")
    terminal.enter("launcher kill robo_2")
    terminal.wait_for("unknown process 'robo_2'")
    terminal.enter("python -m launcher clear")
    terminal.wait_until(lambda: "robo_2" not in terminal.text, "an empty screen")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


BURST = """
        py("input()\\nfor n in range(10000): print(f'line {n:05} ' + 'x' * 40)\\ninput()",
           name="burst"),
"""


@pytest.mark.thorough
def test_a_burst_of_10_000_lines_stays_whole_and_in_order_above_the_prompt(bench: Bench):
    terminal = bench.screen_terminal(BURST)
    terminal.wait_for_prompt()
    terminal.enter("send burst go")
    terminal.type("half a li")
    terminal.wait_until(lambda: "line 09999" in terminal.text, "the last line", 300.0)
    terminal.wait_until(lambda: "> half a li" in terminal.text, "what is typed")
    terminal.wait_until(
        lambda: terminal.cursor == (terminal.prompt_row, len("> half a li")), "the cursor behind it"
    )
    terminal.wait_until(
        lambda: not any(terminal.rows[terminal.prompt_row + 3 :]), "nothing below the bar"
    )
    shown = [line for line in terminal.scrolled if "] line " in line]
    assert shown == [f"[burst-1] line {n:05} {'x' * 40}" for n in range(10000)]
    terminal.ctrl_c()
    terminal.exit_code()
