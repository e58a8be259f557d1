"""What the console shows: top, logs, unfinished lines, progress bars, narrow terminals."""

from __future__ import annotations

import re

import pytest

from tests.support.benches import Bench
from tests.support.console_runs import TICKS
from tests.support.screen_terminal import ScreenTerminal

ENDS = """
        py("input(); raise SystemExit(4)", name="code"),
        py("input(); import os; os.abort()", name="abort"),
        py("input()", name="good"),
"""


def test_the_bar_tells_what_hides_output_and_how_processes_ended(bench: Bench):
    terminal = bench.screen_terminal(TICKS + ENDS, columns=120)
    terminal.wait_for_prompt()
    for line in ("level ERROR", "grep Fleet", "solo robot_1", "unmute", "solo robot_1"):
        terminal.enter(line)
    filters = re.compile(
        r"level>=ERROR  grep 'Fleet'  solo robot_1  hidden [1-9]\d* \| `show` shows everything"
    )
    terminal.wait_until(lambda: filters.match(terminal.below_prompt(2)), "the filters")
    terminal.wait_for("`level ERROR` and `grep 'Fleet'` still hide lines")
    terminal.enter("show")
    terminal.wait_until(lambda: terminal.below_prompt(2).startswith("help |"), "no filter")
    ticks = sum("] tick" in row for row in terminal.scrolled)
    terminal.wait_until(
        lambda: sum("] tick" in row for row in terminal.scrolled) > ticks, "all lines"
    )
    for name in ("code", "abort", "good"):
        terminal.enter(f"send {name} go")
    terminal.wait_until(
        lambda: "code exit 4 | abort SIGABRT | good finished" in terminal.below_prompt(1),
        "the ends",
    )
    terminal.ctrl_c()
    terminal.exit_code()


def test_top_is_live_above_the_prompt_until_a_key_is_pressed(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("top")
    terminal.wait_until(lambda: "any other key ends this" in terminal.text, "the table's footer")
    terminal.wait_until(lambda: "robot_2-2  running" in terminal.text, "the table")
    terminal.wait_until(lambda: "monitor-3  running" in terminal.text, "its row")
    table = next(row for row in terminal.rows if row.startswith("monitor-3 "))
    terminal.wait_until(
        lambda: table not in terminal.rows and "monitor-3  running" in terminal.text,
        "other figures",
    )
    terminal.wait_until(
        lambda: "any other key" in terminal.below_prompt(2), "the footer below the bar"
    )
    terminal.type("x")
    terminal.wait_until(lambda: "running" not in terminal.text, "no table")
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == ">", "the prompt")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_ctrl_c_ends_what_is_watched_and_not_the_run(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    for verb in ("top", "logs -f monitor"):
        terminal.enter(verb)
        terminal.wait_until(lambda: "key ends this" in terminal.text, verb)
        terminal.ctrl_c()
        terminal.wait_until(lambda: "key ends this" not in terminal.text, f"the end of {verb}")
        terminal.wait_until(lambda: terminal.below_prompt(2).startswith("help |"), "the bar again")
    terminal.enter("info monitor")
    terminal.wait_for("| state        running")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert sum("user interrupted" in row for row in terminal.scrolled) == 1


def test_logs_are_followed_until_a_key_is_pressed(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("mute robot_2")
    terminal.enter("logs -n 3 -f robot_2")
    terminal.wait_for("| [robot_2-2] tock", "any key ends this")
    terminal.type(" ")
    terminal.wait_until(lambda: "any key ends this" not in terminal.text, "the end of it")
    terminal.enter("info robot_2")
    terminal.wait_for("SIGINT, after 5 s SIGTERM, after 5 s SIGKILL")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def test_a_coloured_mark_distinguishes_answers_from_process_output(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("mute robot_1 robot_2")
    terminal.wait_for("| robot_1-1 is muted", "| robot_2-2 is muted")
    terminal.enter("bogus")
    terminal.wait_for("| error: unknown verb 'bogus'", "| hint: `help all` lists all verbs")
    cells = terminal.cells()
    marks = {terminal.cells()[n][0] for n, row in enumerate(terminal.rows) if row.startswith("| ")}
    assert marks == {("|", "cyan", True, False)}
    (row,) = (cells[n] for n, text in enumerate(terminal.rows) if text.startswith("| error"))
    assert {colour for _, colour, *_ in row[2:29]} == {"red"}
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def is_above_prompt(terminal: ScreenTerminal) -> bool:
    """Whether the whole help is there, with its keys."""
    rows, prompt = terminal.rows, terminal.prompt_row
    return (
        rows[prompt - 12].startswith("ps, top, info NAME")
        and rows[prompt - 1].startswith("help all, help VERB")
        and terminal.below_prompt(2) == "Esc closes the help"
    )


@pytest.mark.thorough
def test_help_stays_above_the_prompt_while_lines_flow_until_esc_or_a_line(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    for close in ("\x1b", "info monitor\r"):
        terminal.enter("help")
        terminal.wait_until(lambda: "ps, top, info NAME" in terminal.text, "the help")
        before = len(terminal.scrolled)
        terminal.wait_until(lambda n=before: len(terminal.scrolled) > n + 30, "output flows")
        terminal.wait_until(lambda: is_above_prompt(terminal), "it has stayed")
        terminal.type(close)
        terminal.wait_until(lambda: "ps, top, info NAME" not in terminal.text, "it is closed")
    terminal.wait_for("| state        running")
    terminal.enter("help all")
    terminal.wait_for("| logs [NAME ...] [-n N] [-f]", "| clear ", "| Ctrl-Z ")
    terminal.enter("help kill")
    terminal.wait_for("| usage: kill NAME ... [-s SIGNAL]")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def test_help_fits_a_small_terminal_and_can_be_scrolled(bench: Bench):
    terminal = bench.screen_terminal(TICKS, columns=50, rows=12)
    terminal.wait_for_prompt()
    terminal.enter("help")
    terminal.wait_until(lambda: "ps, top, info NAME" in terminal.rows, "the help")
    terminal.wait_until(lambda: "  state, CPU, memory; live; all facts" in terminal.rows, "texts")
    terminal.wait_until(
        lambda: terminal.below_prompt(2) == "Esc closes the help  PageUp, PageDown scroll", "keys"
    )
    terminal.type("\x1b[6~" * 4)
    terminal.wait_until(lambda: "help all, help VERB" in terminal.rows, "its end")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_the_link_of_the_page_stays_in_the_bar_of_a_run_that_serves_it(bench: Bench):
    terminal = bench.screen_terminal(TICKS, "--web", "--web-port", "0")
    terminal.wait_for_prompt()
    shown = re.compile(r"\| page: http://127\.0\.0\.1:(\d+)/\?token=\S+$")
    terminal.wait_until(lambda: shown.search(terminal.below_prompt(2)), "the link")
    found = shown.search(terminal.below_prompt(2))
    assert found is not None
    terminal.resize(70, 24)
    short = f"| w opens http://127.0.0.1:{found[1]}"
    terminal.wait_until(lambda: terminal.below_prompt(2).endswith(short), "a short form")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


RUDE = """
        py("print('\\x1b[2J\\x1b]0;title\\x07\\x1b[31mred\\x1b[0m\\x1b[5A')\\ninput()",
           name="rude"),
"""


@pytest.mark.thorough
def test_escape_sequences_in_old_lines_are_not_executed(bench: Bench):
    terminal = bench.screen_terminal(RUDE)
    terminal.wait_for_prompt()
    terminal.wait_for("red")
    terminal.enter("logs rude")
    terminal.wait_for("> logs rude")
    terminal.wait_until(lambda: terminal.text.count("red") == 2, "the line again")
    terminal.wait_until(
        lambda: "> logs rude" in terminal.rows[: terminal.prompt_row], "it above the prompt"
    )
    assert "process started" in terminal.text  # nothing was cleared
    terminal.ctrl_c()
    terminal.exit_code()


PARTIAL = """
        py("import time\\nprint('Password: ', end='', flush=True)\\ninput()\\nprint('thanks')"
           "\\ninput()", name="asker"),
"""


def test_an_unfinished_line_of_a_process_is_shown_above_the_prompt(bench: Bench):
    terminal = bench.screen_terminal(PARTIAL)
    terminal.wait_for_prompt()
    terminal.wait_until(
        lambda: terminal.rows[terminal.prompt_row - 1] == "[asker-1] Password:", "the question"
    )
    terminal.enter("send asker secret")
    terminal.wait_for("[asker-1] Password: thanks")
    terminal.ctrl_c()
    terminal.exit_code()


EARLY = """
        py("print('Name? ', end='', flush=True)\\nprint('thanks,', input(), flush=True)\\ninput()",
           name="asker"),
        py("while True: print('you said', input(), flush=True)", name="parrot"),
"""


@pytest.mark.thorough
def test_a_question_from_before_the_prompt_stays_above_it_and_is_in_the_log(bench: Bench):
    terminal = bench.screen_terminal(EARLY)
    terminal.wait_for("[asker-1] Name?")
    terminal.wait_for_prompt()
    terminal.enter("send parrot one")
    terminal.wait_for("[parrot-2] you said one")
    terminal.wait_until(
        lambda: terminal.rows[terminal.prompt_row - 1] == "[asker-1] Name?", "the question"
    )
    assert terminal.text.count("Name?") == 1
    terminal.enter("logs asker")
    terminal.wait_for("| [asker-1] Name?")
    terminal.type("\x1bOQ")  # F2
    terminal.wait_until(lambda: "Enter log" in terminal.text, "the list")
    terminal.type("\r")
    terminal.wait_until(lambda: terminal.text.count("Name?") == 3, "the question in its log")
    terminal.type("\x03")
    terminal.wait_until(lambda: "help | F2" in terminal.text, "the prompt")
    terminal.enter("send asker Ada")
    terminal.wait_for("[asker-1] Name? thanks, Ada")
    terminal.ctrl_c()
    terminal.exit_code()


PATIENT = """
        py("print('Name? ', end='', flush=True)\\nprint('thanks,', input(), flush=True)\\n"
           "print('Age? ', end='', flush=True)\\ninput()", name="asker"),
        py("while True: print('you said', input(), flush=True)", name="parrot"),
"""


@pytest.mark.thorough
def test_a_question_stays_above_the_prompt_while_others_write_until_it_is_answered(bench: Bench):
    terminal = bench.screen_terminal(PATIENT)
    terminal.wait_for_prompt()
    terminal.wait_for("[asker-1] Name?")
    terminal.enter("restart asker")  # asked while the console is there
    for word in ("one", "two"):
        terminal.enter(f"send parrot {word}")
        terminal.wait_for(f"[parrot-2] you said {word}")
        terminal.wait_until(
            lambda: terminal.rows[terminal.prompt_row - 1] == "[asker-1] Name?", "the question"
        )
        # the one of its first life has ended with that
        terminal.wait_until(lambda: terminal.text.count("Name?") == 2, "both questions")
    terminal.enter("send asker Ada")
    terminal.wait_for("[asker-1] Name? thanks, Ada")
    terminal.wait_until(
        lambda: terminal.rows[terminal.prompt_row - 1] == "[asker-1] Age?", "the next one"
    )
    # a whole line, which has gone up as others do
    terminal.wait_until(lambda: terminal.text.count("Name?") == 2, "both questions")
    terminal.enter("mute asker")
    terminal.enter("stop asker")
    terminal.wait_for("| asker-1 stopped in ")
    terminal.enter("send parrot three")
    last = "[parrot-2] you said three"
    terminal.wait_until(
        lambda: last in terminal.rows[terminal.prompt_row - 2 : terminal.prompt_row], "it"
    )
    terminal.wait_until(
        lambda: "[asker-1] Age?" not in terminal.text.partition(last)[2], "no question any more"
    )
    terminal.ctrl_c()
    terminal.exit_code()


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
    terminal = bench.screen_terminal(BAR.replace("{FORM}", form), *words)
    terminal.wait_for("[bar-1] ready")
    if not words:
        terminal.wait_for_prompt()
    for number in range(3):
        bench.ask_run(terminal.pid, "send", "bar", "go")
        terminal.wait_until(
            lambda n=number: f"[bar-1] done {n} of 3" in terminal.rows, f"step {number}"
        )
        terminal.wait_until(lambda: sum("of 3" in row for row in terminal.rows) == 1, "one bar")
    bench.ask_run(terminal.pid, "send", "bar", "go")
    terminal.wait_until(lambda: "[bar-1] all done" in terminal.rows, "the end")
    terminal.wait_until(lambda: not any("of 3" in row for row in terminal.rows), "no bar")
    terminal.ctrl_c()
    terminal.exit_code()


WIDE = """
        py("import time\\nwhile True:\\n"
           " print('\\x1b[35m機器人 ready 🤖\\x1b[0m ' + 'x' * 50, flush=True)\\n"
           " time.sleep(0.05)", name="wide"),
"""


@pytest.mark.thorough
def test_a_narrow_terminal_shows_what_fits_and_wide_characters_stay_whole(bench: Bench):
    terminal = bench.screen_terminal(WIDE, columns=20, rows=10)
    terminal.wait_for_prompt()
    terminal.enter("info wide")
    terminal.wait_until(lambda: any("機器人" in row for row in terminal.rows), "them")
    terminal.wait_until(lambda: terminal.below_prompt(1).startswith("wide "), "the bar")
    terminal.wait_until(lambda: all(len(row) <= 20 for row in terminal.rows), "rows that fit")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_fifty_processes_are_counted_and_each_can_be_scrolled_to(bench: Bench):
    many = "".join(f'py("input()", name="worker_{n}"),' for n in range(50))
    terminal = bench.screen_terminal(many, columns=80)
    terminal.wait_for_prompt()
    terminal.wait_until(lambda: "50 running" in terminal.text, "the count", 60.0)
    terminal.enter("stop worker_7")
    terminal.wait_until(lambda: "49 running, 1 stopped | worker_7 stopped" in terminal.text, "who")
    terminal.enter("top")
    terminal.wait_until(lambda: "1-16 of 50 by cpu: 34 more below" in terminal.rows, "the table")
    terminal.type("n")
    terminal.wait_until(lambda: "1-16 of 50 by name: 34 more below" in terminal.rows, "the first")
    terminal.type("\x1b[6~\x1b[B")
    terminal.wait_until(
        lambda: "18-33 of 50 by name: " in terminal.text, "a page and a row further"
    )
    terminal.wait_until(
        lambda: any(row.startswith("worker_17-18 ") for row in terminal.rows), "the row"
    )
    terminal.resize(20, 5)
    terminal.wait_until(
        lambda: any(r.startswith("worke…17-18") for r in terminal.rows), "two of them"
    )
    terminal.wait_until(lambda: terminal.prompt_row == 3, "the prompt")
    terminal.type("x")
    terminal.resize(80, 24)
    terminal.enter("quit")
    terminal.exit_code(60.0)


@pytest.mark.thorough
def test_no_color_applies_to_the_console_too(bench: Bench):
    bench.env["NO_COLOR"] = "1"
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.enter("top")
    terminal.wait_until(lambda: "robot_2-2  running" in terminal.text, "the table")
    terminal.enter("no-such-verb")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert not re.search(rb"\x1b\[[0-9;]*(3[0-7]|9[0-7]|38)[;m]", terminal.raw)


PRINTS = """
        TimerAction(
            period=1.0, actions=[OpaqueFunction(function=lambda c: print("from the file"))]),
        py("input()", name="quiet"),
"""


def test_output_of_a_launch_file_gets_its_own_line(bench: Bench):
    terminal = bench.screen_terminal(PRINTS)
    terminal.wait_for_prompt()
    terminal.type("half a li")
    terminal.wait_until(lambda: "> half a li" in terminal.rows, "what is typed")
    terminal.wait_until(lambda: "from the file" in terminal.rows, "a whole row")
    terminal.wait_until(lambda: terminal.rows[terminal.prompt_row] == "> half a li", "the prompt")
    terminal.ctrl_c()
    terminal.exit_code()
