"""The console in a real terminal, looked at through a terminal emulator."""

from __future__ import annotations

import re

import pytest

from tests.process.conftest import Bench

TICKS = """
        py("import time\\nwhile True: print('tick', flush=True); time.sleep(0.05)", name="robot_1"),
        py("import time\\nwhile True: print('tock', flush=True); time.sleep(0.05)", name="robot_2"),
        py("import time\\nwhile True: time.sleep(1)", name="monitor"),
"""


def test_a_process_is_killed_and_started_again_while_lines_flow(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.wait_for("robot_1-1] tick")
    glass.enter("kill robot_2")
    glass.wait_for("> kill robot_2", "robot_2-2 stopped in ")
    glass.wait_until(lambda: "robot_2 stopped" in glass.text, "the bar tells")
    glass.enter("start robot_2")
    glass.wait_for("robot_2-2 started with pid ")
    glass.wait_until(lambda: "robot_2 stopped" not in glass.text, "the bar tells")
    glass.ctrl_c()
    assert glass.exit_code() == 0, glass.text


def test_the_terminal_is_as_it_was_after_the_end_and_the_footer_is_gone(bench: Bench):
    glass = bench.glass(TICKS)
    before = glass.settings()
    glass.wait_for_prompt()
    assert glass.settings() != before
    glass.enter("quit")
    assert glass.exit_code() == 0
    assert glass.settings() == before
    assert not glass.cursor_is_hidden
    assert glass.prompt_row == -1 or glass.rows[glass.prompt_row] == "> quit"
    assert "Ctrl-C stops the run" not in glass.text
    assert bench.survivors() == []


def test_the_scroll_back_and_the_mouse_stay_the_terminals_own(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("top")
    glass.wait_until(lambda: "any key ends this" in glass.text, "the table")
    glass.ctrl_c()
    assert glass.exit_code() == 0
    modes = {int(mode) for mode in re.findall(rb"\x1b\[\?(\d+)h", glass.raw)}
    assert modes <= {7, 12, 25, 2004}  # wrapping, cursor, pastes; no other screen, no mouse
    assert any("process started with pid" in row for row in glass.scrolled)


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
    glass.wait_until(lambda: "let paused processes go on (SIGCONT)" in glass.rows, "what it is")
    glass.type("\x15kill mo\t")
    glass.wait_until(lambda: "> kill monitor" in glass.text, "the whole name")
    glass.type("\x15kill -s SIGTE\t")
    glass.wait_until(lambda: "> kill -s SIGTERM" in glass.text, "the whole signal")
    glass.type("\x15stop rob\t")
    glass.wait_until(lambda: "robot_*  robot_1  robot_2" in glass.text, "names and the glob")
    glass.type("*\t")
    glass.wait_until(lambda: "> stop robot_1-1 robot_2-2" in glass.text, "what it stands for")
    glass.ctrl_c()
    assert glass.exit_code() == 0


def test_a_misspelt_verb_and_name_are_told_with_what_was_meant(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("kil robot_2")
    glass.wait_for("error: there is no verb 'kil'", "hint: did you mean kill?")
    glass.enter("kill robo_2")
    glass.wait_for("there is no process 'robo_2'")
    glass.ctrl_c()
    assert glass.exit_code() == 0


BURST = """
        py("input()\\nfor n in range(10000): print(f'line {n:05} ' + 'x' * 40)\\ninput()",
           name="burst"),
"""


def test_a_burst_of_10_000_lines_stays_whole_and_in_order_above_the_prompt(bench: Bench):
    glass = bench.glass(BURST)
    glass.wait_for_prompt()
    glass.enter("send burst go")
    glass.type("half a li")
    glass.wait_until(lambda: "line 09999" in glass.text, "the last line", 60.0)
    glass.wait_until(lambda: "> half a li" in glass.text, "what is typed")
    row = glass.prompt_row
    assert glass.cursor == (row, len("> half a li"))
    assert [text for text in glass.rows[row + 3 :] if text] == []
    shown = [line for line in glass.scrolled if "] line " in line]
    assert shown == [f"[burst-1] line {n:05} {'x' * 40}" for n in range(10000)]
    glass.ctrl_c()
    glass.exit_code()


# ---- keys


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
           "print('up', flush=True)\\nwhile True: time.sleep(1)", name="stubborn"),
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
    glass.wait_for("robot_2-2 is muted; its files go on")
    glass.enter("quit")
    assert glass.exit_code() == 0
    again = bench.glass(TICKS)
    again.wait_for_prompt()
    again.type("\x1b[A\x1b[A")
    again.wait_until(lambda: again.rows[again.prompt_row] == "> mute robot_2", "the line")
    again.ctrl_c()
    assert again.exit_code() == 0


def test_ctrl_r_finds_a_line(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("mute robot_2")
    glass.wait_for("> mute robot_2", "robot_2-2 is muted")
    glass.enter("ps")
    glass.wait_for("> ps")
    glass.type("\x12obo")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> mute robot_2", "the line")
    glass.ctrl_c()
    assert glass.exit_code() == 0


def test_each_line_of_a_paste_is_a_line_of_its_own(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.type("\x1b[200~mute robot_1\nmute robot_2\r\nsolo mon\x1b[201~")
    glass.wait_for("> mute robot_1", "robot_1-1 is muted", "> mute robot_2", "robot_2-2 is muted")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> solo mon", "the rest")
    glass.ctrl_c()
    assert glass.exit_code() == 0


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
        "there is no verb 'bogus'",
        "> unmute",
        "> grep tock robot_2",
        "robot_2-2 is shown with",
    ]
    glass.wait_for(*expected)
    rows = glass.scrolled
    places = [next(n for n, row in enumerate(rows) if text in row) for text in expected]
    assert places == sorted(places), "\n".join(rows)
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.parametrize("typed", [b"\xff\r", b"caf\xe9\r", b"\xff\xfe\x00\r", b"\x00\r"], ids=repr)
def test_bytes_that_are_no_text_leave_the_console_as_it_is(bench: Bench, typed: bytes):
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


def test_a_flood_on_a_slow_terminal_can_be_muted(bench: Bench):
    glass = bench.glass(FLOOD)
    glass.bytes_per_s, glass.emulates = 400_000, False
    glass.wait_until(lambda: b"\x1b[?2004h" in glass.raw, "the prompt", 60.0)
    glass.enter("mute flood")
    begun = len(glass.raw)
    glass.wait_until(lambda: b"flood-1 is muted" in glass.raw[begun:], "the answer", 60.0)
    assert len(glass.raw) - begun < 2_000_000  # what was on its way, and no more
    glass.bytes_per_s = None
    glass.ctrl_c()
    assert glass.exit_code() == 0


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


# ---- what is shown


def test_top_is_live_above_the_prompt_until_a_key_is_pressed(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("top")
    glass.wait_until(lambda: "any key ends this" in glass.text, "the table's footer")
    glass.wait_until(lambda: "robot_2-2  running" in glass.text, "the table")
    table = next(row for row in glass.rows if row.startswith("monitor-3 "))
    glass.wait_until(
        lambda: table not in glass.rows and "monitor-3  running" in glass.text, "other figures"
    )
    assert glass.rows.index("any key ends this") > glass.prompt_row
    glass.type("x")
    glass.wait_until(lambda: "running" not in glass.text, "no table")
    assert glass.rows[glass.prompt_row] == ">"
    glass.ctrl_c()
    assert glass.exit_code() == 0


def test_logs_are_followed_until_a_key_is_pressed(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("mute robot_2")
    glass.enter("logs -n 3 -f robot_2")
    glass.wait_for("| [robot_2-2] tock", "any key ends this")
    glass.type(" ")
    glass.wait_until(lambda: "any key ends this" not in glass.text, "the end of it")
    glass.enter("info robot_2")
    glass.wait_for("SIGINT, after 5 s SIGTERM, after 5 s SIGKILL")
    glass.ctrl_c()
    assert glass.exit_code() == 0


RUDE = """
        py("print('\\x1b[2J\\x1b]0;title\\x07\\x1b[31mred\\x1b[0m\\x1b[5A')\\ninput()",
           name="rude"),
"""


def test_old_lines_cannot_steer_the_terminal(bench: Bench):
    glass = bench.glass(RUDE)
    glass.wait_for_prompt()
    glass.enter("logs rude")
    glass.wait_for("> logs rude")
    glass.wait_until(lambda: glass.text.count("red") == 2, "the line again")
    assert glass.rows.index("> logs rude") < glass.prompt_row
    assert "process started" in glass.text  # nothing was cleared
    glass.ctrl_c()
    glass.exit_code()


PARTIAL = """
        py("import time\\nprint('Password: ', end='', flush=True)\\ninput()\\nprint('thanks')"
           "\\ninput()", name="asker"),
"""


def test_the_unfinished_line_of_a_process_stands_above_the_prompt(bench: Bench):
    glass = bench.glass(PARTIAL)
    glass.wait_for_prompt()
    glass.wait_until(
        lambda: glass.rows[glass.prompt_row - 1] == "[asker-1] Password:", "the question"
    )
    glass.enter("send asker secret")
    glass.wait_for("[asker-1] Password: thanks")
    glass.ctrl_c()
    glass.exit_code()


BAR = """
        py("print('ready', flush=True)\\n"
           "for n in range(3): input(); print(f'{FORM}', end='', flush=True)\\n"
           "input(); print('\\\\rall done')\\ninput()", name="bar", emulate_tty=True),
"""


@pytest.mark.parametrize("words", [(), ("--no-console",)], ids=["console", "no console"])
@pytest.mark.parametrize(
    "form", [r"\\rdone {n} of 3", r"done {n} of 3\\r"], ids=["before", "behind"]
)
def test_a_progress_bar_moves_in_one_line_and_ends_as_a_whole_one(
    bench: Bench, words: tuple[str, ...], form: str
):
    glass = bench.glass(BAR.replace("{FORM}", form), *words)
    glass.wait_for("[bar-1] ready")
    if not words:
        glass.wait_for_prompt()
    for number in range(3):
        bench.ask_run(glass.pid, "send", "bar", "go")
        glass.wait_until(lambda n=number: f"[bar-1] done {n} of 3" in glass.rows, f"step {number}")
        assert sum("of 3" in row for row in glass.rows) == 1
    bench.ask_run(glass.pid, "send", "bar", "go")
    glass.wait_until(lambda: "[bar-1] all done" in glass.rows, "the end")
    assert not any("of 3" in row for row in glass.rows)
    glass.ctrl_c()
    glass.exit_code()


WIDE = """
        py("import time\\nwhile True:\\n"
           " print('\\x1b[35m機器人 ready 🤖\\x1b[0m ' + 'x' * 50, flush=True)\\n"
           " time.sleep(0.05)", name="wide"),
"""


def test_a_narrow_terminal_shows_what_fits_and_wide_characters_stay_whole(bench: Bench):
    glass = bench.glass(WIDE, columns=20, rows=10)
    glass.wait_for_prompt()
    glass.enter("info wide")
    glass.wait_until(lambda: any("機器人" in row for row in glass.rows), "them")
    glass.wait_until(lambda: glass.rows[glass.prompt_row + 1].startswith("wide "), "the bar")
    assert all(len(row) <= 20 for row in glass.rows)
    glass.ctrl_c()
    assert glass.exit_code() == 0


def test_fifty_processes_are_counted_and_those_in_trouble_named(bench: Bench):
    many = "".join(f'py("input()", name="worker_{n}"),' for n in range(50))
    glass = bench.glass(many, columns=80)
    glass.wait_for_prompt()
    glass.wait_until(lambda: "50 running" in glass.text, "the count", 60.0)
    glass.enter("stop worker_7")
    glass.wait_until(lambda: "49 running, 1 stopped | worker_7 stopped" in glass.text, "who")
    glass.enter("quit")
    glass.exit_code(60.0)


def test_no_color_means_none_of_the_console_either(bench: Bench):
    bench.env["NO_COLOR"] = "1"
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("top")
    glass.wait_until(lambda: "robot_2-2  running" in glass.text, "the table")
    glass.enter("no-such-verb")
    glass.ctrl_c()
    assert glass.exit_code() == 0
    assert not re.search(rb"\x1b\[[0-9;]*(3[0-7]|9[0-7]|38)[;m]", glass.raw)


PRINTS = """
        TimerAction(
            period=1.0, actions=[OpaqueFunction(function=lambda c: print("from the file"))]),
        py("input()", name="quiet"),
"""


def test_what_a_launch_file_prints_stands_in_a_line_of_its_own(bench: Bench):
    glass = bench.glass(PRINTS)
    glass.wait_for_prompt()
    glass.type("half a li")
    glass.wait_until(lambda: "> half a li" in glass.rows, "what is typed")
    glass.wait_until(lambda: "from the file" in glass.rows, "a whole row")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> half a li", "the prompt")
    glass.ctrl_c()
    glass.exit_code()
