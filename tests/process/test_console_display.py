"""What the console shows: top, logs, unfinished lines, progress bars, narrow terminals."""

from __future__ import annotations

import re

import pytest

from tests.process.conftest import Bench
from tests.support.console_runs import TICKS


def test_top_is_live_above_the_prompt_until_a_key_is_pressed(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("top")
    glass.wait_until(lambda: "any other key ends this" in glass.text, "the table's footer")
    glass.wait_until(lambda: "robot_2-2  running" in glass.text, "the table")
    glass.wait_until(lambda: "monitor-3  running" in glass.text, "its row")
    table = next(row for row in glass.rows if row.startswith("monitor-3 "))
    glass.wait_until(
        lambda: table not in glass.rows and "monitor-3  running" in glass.text, "other figures"
    )
    glass.wait_until(lambda: "any other key" in glass.below_prompt(2), "the footer below the bar")
    glass.type("x")
    glass.wait_until(lambda: "running" not in glass.text, "no table")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == ">", "the prompt")
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
def test_ctrl_c_ends_what_is_watched_and_not_the_run(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    for verb in ("top", "logs -f monitor"):
        glass.enter(verb)
        glass.wait_until(lambda: "key ends this" in glass.text, verb)
        glass.ctrl_c()
        glass.wait_until(lambda: "key ends this" not in glass.text, f"the end of {verb}")
        glass.wait_until(lambda: glass.below_prompt(2).startswith("help |"), "the bar again")
    glass.enter("info monitor")
    glass.wait_for("| state        running")
    glass.ctrl_c()
    assert glass.exit_code() == 0
    assert sum("user interrupted" in row for row in glass.scrolled) == 1


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


def test_a_coloured_mark_distinguishes_answers_from_process_output(bench: Bench):
    glass = bench.glass(TICKS)
    glass.wait_for_prompt()
    glass.enter("mute robot_1 robot_2")
    glass.wait_for("| robot_1-1 is muted", "| robot_2-2 is muted")
    glass.enter("bogus")
    glass.wait_for("| error: unknown verb 'bogus'", "| hint: `help` lists all verbs")
    cells = glass.cells()
    marks = {glass.cells()[n][0] for n, row in enumerate(glass.rows) if row.startswith("| ")}
    assert marks == {("|", "cyan", True)}
    (row,) = (cells[n] for n, text in enumerate(glass.rows) if text.startswith("| error"))
    assert {colour for _, colour, _ in row[2:29]} == {"red"}
    glass.ctrl_c()
    assert glass.exit_code() == 0


RUDE = """
        py("print('\\x1b[2J\\x1b]0;title\\x07\\x1b[31mred\\x1b[0m\\x1b[5A')\\ninput()",
           name="rude"),
"""


@pytest.mark.thorough
def test_old_lines_cannot_steer_the_terminal(bench: Bench):
    glass = bench.glass(RUDE)
    glass.wait_for_prompt()
    glass.wait_for("red")
    glass.enter("logs rude")
    glass.wait_for("> logs rude")
    glass.wait_until(lambda: glass.text.count("red") == 2, "the line again")
    glass.wait_until(lambda: "> logs rude" in glass.rows[: glass.prompt_row], "it above the prompt")
    assert "process started" in glass.text  # nothing was cleared
    glass.ctrl_c()
    glass.exit_code()


PARTIAL = """
        py("import time\\nprint('Password: ', end='', flush=True)\\ninput()\\nprint('thanks')"
           "\\ninput()", name="asker"),
"""


def test_an_unfinished_line_of_a_process_is_shown_above_the_prompt(bench: Bench):
    glass = bench.glass(PARTIAL)
    glass.wait_for_prompt()
    glass.wait_until(
        lambda: glass.rows[glass.prompt_row - 1] == "[asker-1] Password:", "the question"
    )
    glass.enter("send asker secret")
    glass.wait_for("[asker-1] Password: thanks")
    glass.ctrl_c()
    glass.exit_code()


PATIENT = """
        py("print('Name? ', end='', flush=True)\\nprint('thanks,', input(), flush=True)\\n"
           "print('Age? ', end='', flush=True)\\ninput()", name="asker"),
        py("while True: print('you said', input(), flush=True)", name="parrot"),
"""


@pytest.mark.thorough
def test_a_question_stays_above_the_prompt_while_others_write_until_it_is_answered(bench: Bench):
    glass = bench.glass(PATIENT)
    glass.wait_for_prompt()
    glass.wait_for("[asker-1] Name?")
    glass.enter("restart asker")  # asked while the console is there
    for word in ("one", "two"):
        glass.enter(f"send parrot {word}")
        glass.wait_for(f"[parrot-2] you said {word}")
        glass.wait_until(
            lambda: glass.rows[glass.prompt_row - 1] == "[asker-1] Name?", "the question"
        )
        # the one of its first life has ended with that
        glass.wait_until(lambda: glass.text.count("Name?") == 2, "both questions")
    glass.enter("send asker Ada")
    glass.wait_for("[asker-1] Name? thanks, Ada")
    glass.wait_until(lambda: glass.rows[glass.prompt_row - 1] == "[asker-1] Age?", "the next one")
    # a whole line, which has gone up as others do
    glass.wait_until(lambda: glass.text.count("Name?") == 2, "both questions")
    glass.enter("mute asker")
    glass.enter("stop asker")
    glass.wait_for("| asker-1 stopped in ")
    glass.enter("send parrot three")
    last = "[parrot-2] you said three"
    glass.wait_until(lambda: last in glass.rows[glass.prompt_row - 2 : glass.prompt_row], "it")
    glass.wait_until(
        lambda: "[asker-1] Age?" not in glass.text.partition(last)[2], "no question any more"
    )
    glass.ctrl_c()
    glass.exit_code()


BAR = """
        py("print('ready', flush=True)\\n"
           "for n in range(3): input(); print(f'{FORM}', end='', flush=True)\\n"
           "input(); print('\\\\rall done')\\ninput()", name="bar", emulate_tty=True),
"""


@pytest.mark.thorough
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
        glass.wait_until(lambda: sum("of 3" in row for row in glass.rows) == 1, "one bar")
    bench.ask_run(glass.pid, "send", "bar", "go")
    glass.wait_until(lambda: "[bar-1] all done" in glass.rows, "the end")
    glass.wait_until(lambda: not any("of 3" in row for row in glass.rows), "no bar")
    glass.ctrl_c()
    glass.exit_code()


WIDE = """
        py("import time\\nwhile True:\\n"
           " print('\\x1b[35m機器人 ready 🤖\\x1b[0m ' + 'x' * 50, flush=True)\\n"
           " time.sleep(0.05)", name="wide"),
"""


@pytest.mark.thorough
def test_a_narrow_terminal_shows_what_fits_and_wide_characters_stay_whole(bench: Bench):
    glass = bench.glass(WIDE, columns=20, rows=10)
    glass.wait_for_prompt()
    glass.enter("info wide")
    glass.wait_until(lambda: any("機器人" in row for row in glass.rows), "them")
    glass.wait_until(lambda: glass.below_prompt(1).startswith("wide "), "the bar")
    glass.wait_until(lambda: all(len(row) <= 20 for row in glass.rows), "rows that fit")
    glass.ctrl_c()
    assert glass.exit_code() == 0


@pytest.mark.thorough
def test_fifty_processes_are_counted_and_each_can_be_scrolled_to(bench: Bench):
    many = "".join(f'py("input()", name="worker_{n}"),' for n in range(50))
    glass = bench.glass(many, columns=80)
    glass.wait_for_prompt()
    glass.wait_until(lambda: "50 running" in glass.text, "the count", 60.0)
    glass.enter("stop worker_7")
    glass.wait_until(lambda: "49 running, 1 stopped | worker_7 stopped" in glass.text, "who")
    glass.enter("top")
    glass.wait_until(lambda: "1-16 of 50 by cpu: 34 more below" in glass.rows, "the table")
    glass.type("n")
    glass.wait_until(lambda: "1-16 of 50 by name: 34 more below" in glass.rows, "the first")
    glass.type("\x1b[6~\x1b[B")
    glass.wait_until(lambda: "18-33 of 50 by name: " in glass.text, "a page and a row further")
    glass.wait_until(lambda: any(row.startswith("worker_17-18 ") for row in glass.rows), "the row")
    glass.resize(20, 5)
    glass.wait_until(lambda: any(r.startswith("worke…17-18") for r in glass.rows), "two of them")
    glass.wait_until(lambda: glass.prompt_row == 3, "the prompt")
    glass.type("x")
    glass.resize(80, 24)
    glass.enter("quit")
    glass.exit_code(60.0)


@pytest.mark.thorough
def test_no_color_applies_to_the_console_too(bench: Bench):
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


def test_output_of_a_launch_file_gets_its_own_line(bench: Bench):
    glass = bench.glass(PRINTS)
    glass.wait_for_prompt()
    glass.type("half a li")
    glass.wait_until(lambda: "> half a li" in glass.rows, "what is typed")
    glass.wait_until(lambda: "from the file" in glass.rows, "a whole row")
    glass.wait_until(lambda: glass.rows[glass.prompt_row] == "> half a li", "the prompt")
    glass.ctrl_c()
    glass.exit_code()
