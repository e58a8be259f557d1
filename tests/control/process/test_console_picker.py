"""The picker of the console, in a real terminal."""

from __future__ import annotations

import re
import signal

import pytest

from tests.support.benches import Bench
from tests.support.console_runs import TICKS
from tests.support.screen_terminal import ScreenTerminal

F2, UP, DOWN, ENTER, PAGE_UP = "\x1bOQ", "\x1b[A", "\x1b[B", "\r", "\x1b[5~"
OPEN = "Enter log"  # in the line of the keys


def open_picker(terminal: ScreenTerminal) -> None:
    terminal.wait_for_prompt()
    terminal.type(F2)
    terminal.wait_until(lambda: OPEN in terminal.text, "the picker")


def wait_until_closed(terminal: ScreenTerminal) -> None:
    terminal.wait_until(
        lambda: OPEN not in terminal.text and terminal.prompt_row >= 0, "the prompt again"
    )


def chosen(terminal: ScreenTerminal) -> str:
    """The row that is marked; empty if there is none."""
    return next((row for row in terminal.rows if re.match(r">[1-9 ] \S", row)), "")


def test_a_process_is_picked_read_stopped_and_started_below_the_output(bench: Bench):
    terminal = bench.screen_terminal(TICKS, columns=80, rows=20)
    terminal.wait_for_prompt()
    terminal.type("half a li")
    open_picker(terminal)
    terminal.wait_until(lambda: ">1 robot_1-1  running" in terminal.text, "the list")
    ticks = sum("] tick" in row for row in terminal.scrolled)
    terminal.wait_until(
        lambda: sum("] tick" in row for row in terminal.scrolled) > ticks, "output above it"
    )
    keys = "Enter log  s stop  k kill  r restart  m mute  o solo  i info  / search  q back"
    terminal.wait_until(lambda: keys in terminal.rows, "all keys in 80 columns")
    terminal.type("/BOT_2")
    terminal.wait_until(lambda: "processes: 1  /BOT_2" in terminal.rows, "one is found")
    bench.ask_run(terminal.pid, "pause", "robot_*")  # for each line, all is drawn again
    terminal.wait_until(
        lambda: (
            not terminal.cursor_is_hidden
            and terminal.rows[terminal.cursor[0]][: terminal.cursor[1]] == "processes: 1  /BOT_2"
        ),
        "the cursor behind it",
    )
    bench.ask_run(terminal.pid, "resume", "robot_*")
    terminal.type(ENTER + ENTER)
    terminal.wait_until(lambda: "logs robot_2-2: running, following" in terminal.rows, "its log")
    terminal.wait_until(lambda: terminal.rows.count("tock") == 13, "its lines without its name")
    terminal.type(UP)
    terminal.wait_until(lambda: "following" not in terminal.text, "a place")
    terminal.type("s")
    terminal.wait_for("> stop robot_2-2", "| robot_2-2 stopped in ")
    terminal.wait_until(lambda: "logs robot_2-2: stopped: SIGINT, line" in terminal.text, "the end")
    terminal.type("\x1b[F")
    terminal.wait_until(lambda: "KeyboardInterrupt" in terminal.rows, "its last line")
    terminal.type("s")
    terminal.wait_for("| robot_2-2 started with pid ")
    terminal.wait_until(
        lambda: "KeyboardInterrupt" not in terminal.rows and "tock" in terminal.rows, "new lines"
    )
    terminal.type("i")
    terminal.wait_until(lambda: "info robot_2-2: running, line" in terminal.text, "its facts")
    terminal.wait_until(lambda: "stop         SIGINT, after 5 s" in terminal.text, "them")
    terminal.type("q")
    terminal.wait_until(lambda: chosen(terminal).startswith(">1 robot_2-2"), "the list")
    terminal.type("q")
    wait_until_closed(terminal)
    terminal.wait_until(lambda: "> half a li" in terminal.rows, "the line of before")
    terminal.type("\x15")
    terminal.enter("pick")
    terminal.wait_until(lambda: OPEN in terminal.text, "the picker, by its verb")
    terminal.ctrl_c()
    wait_until_closed(terminal)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert sum("user interrupted" in row for row in terminal.scrolled) == 1
    modes = {int(mode) for mode in re.findall(rb"\x1b\[\?(\d+)h", terminal.raw)}
    assert modes <= {7, 12, 25, 2004}  # wrapping, cursor, pastes; no other screen, no mouse
    assert any("process started with pid" in row for row in terminal.scrolled)


LIVELY = """
        TimerAction(period=0.1, actions=[py("input(); raise SystemExit(4)", name="ender",
            on_exit=[py("input()", name="late")])]),
"""


@pytest.mark.thorough
def test_keys_act_on_the_chosen_process_while_others_end_and_start(bench: Bench):
    bench.env["NO_COLOR"] = "1"
    terminal = bench.screen_terminal(TICKS + LIVELY, columns=100, rows=24)
    terminal.wait_until(lambda: "ender" in terminal.below_prompt(1), "all of them")
    open_picker(terminal)
    terminal.type("2")
    terminal.wait_until(lambda: chosen(terminal).startswith(">2 robot_2-2  running"), "the second")
    bench.ask_run(terminal.pid, "send", "ender", "go")
    terminal.wait_until(lambda: " 4 ender-4    exited: exit code 4" in terminal.text, "the end")
    terminal.wait_until(lambda: " 5 late-5     running" in terminal.text, "a new one")
    assert chosen(terminal).startswith(">2 robot_2-2")
    for key, line, answer in (
        ("m", "mute robot_2-2", "robot_2-2 is muted"),
        ("m", "unmute robot_2-2", "robot_2-2 is shown again"),
        ("o", "solo robot_2-2", "robot_2-2 is shown alone"),
        ("o", "unmute", "is shown again"),
        ("r", "restart robot_2-2", "robot_2-2 stopped in "),
        ("k", "kill robot_2-2", "robot_2-2 ended in "),
    ):
        before = terminal.scrolled.count(f"> {line}")
        terminal.type(key)
        terminal.wait_until(lambda c=f"> {line}", n=before: terminal.scrolled.count(c) > n, line)
        terminal.wait_for(answer)
        if key in "mo":  # the keys in the last line are those of now
            other = {"m": ("m mute", "m unmute"), "o": ("o solo", "o end solo")}[key]
            wanted = other[line.startswith(("mute", "solo"))]
            terminal.wait_until(lambda wanted=wanted: wanted in terminal.rows[-1], wanted)
    terminal.wait_until(lambda: "robot_2-2  stopped: SIGKILL" in chosen(terminal), "its end")
    terminal.wait_until(lambda: "s start" in terminal.rows[-1], "what s does now")
    colours = {colour for row in terminal.cells() for _, colour, *_ in row}
    assert colours == {"default"}
    assert b"\x1b[7m" in terminal.raw or b";7m" in terminal.raw  # the chosen one is reversed
    terminal.type("q")
    wait_until_closed(terminal)
    terminal.ctrl_c()
    terminal.exit_code()


@pytest.mark.thorough
def test_a_hundred_processes_in_terminals_of_any_size(bench: Bench):
    many = "".join(f'sh("read line", name="worker_{n}"),' for n in range(100))
    terminal = bench.screen_terminal(many, columns=80, rows=20)
    terminal.wait_for_prompt()
    terminal.wait_until(lambda: "100 running" in terminal.text, "all of them")
    open_picker(terminal)
    terminal.wait_until(lambda: "processes: 1-9 of 100" in terminal.rows, "the first")
    terminal.type("\x1b[6~" * 5 + DOWN)
    terminal.wait_until(lambda: "worker_46-47 " in chosen(terminal), "five pages and one")
    terminal.type("/worker_77" + ENTER + "s")
    terminal.wait_for("| worker_77-78 stopped in ")
    terminal.wait_until(lambda: "99 running, 1 stopped" in terminal.text, "the bar")
    for columns, rows in ((40, 8), (20, 5), (10, 3), (1, 1), (132, 50)):
        terminal.resize(columns, rows)
        terminal.wait_until(
            lambda c=columns: c < 12 or "worker" in chosen(terminal), f"{columns}x{rows}"
        )
        terminal.wait_until(
            lambda c=columns: all(len(row) <= c for row in terminal.rows), "rows that fit"
        )
    terminal.type("\x1b")
    terminal.wait_until(
        lambda: re.search(r"^processes: \d+-\d+ of 100$", terminal.text, re.M), "all"
    )
    terminal.wait_until(lambda: "worker_77-78 " in chosen(terminal), "the same one")
    terminal.type("q")
    wait_until_closed(terminal)
    terminal.ctrl_c()
    terminal.exit_code()


COUNTER = """
        py("import time\\nn = 0\\nwhile True: print('n', n, flush=True); n += 1; time.sleep(0.01)",
           name="counter"), py("input()", name="other"),
"""


@pytest.mark.thorough
def test_the_scroll_back_has_all_output_and_nothing_of_the_picker(bench: Bench):
    terminal = bench.screen_terminal(COUNTER, columns=80, rows=20)
    for _ in range(3):
        open_picker(terminal)
        terminal.type(DOWN + ENTER)
        terminal.wait_until(lambda: "logs other-2: running, " in terminal.text, "a log")
        terminal.type("q")
        terminal.wait_until(lambda: OPEN in terminal.text, "the list")
        terminal.type("/cou" + ENTER + ENTER)
        terminal.wait_until(lambda: "logs counter-1: running, following" in terminal.text, "a log")
        terminal.wait_until(lambda: sum(r.startswith("n ") for r in terminal.rows) == 13, "lines")
        terminal.type(PAGE_UP)
        terminal.wait_until(lambda: "following" not in terminal.text, "a place")
        terminal.ctrl_c()
        wait_until_closed(terminal)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    found = (re.fullmatch(r"\[counter-1\] n (\d+)", row) for row in terminal.scrolled)
    numbers = [int(match[1]) for match in found if match]
    assert numbers == list(range(len(numbers)))
    assert not [
        row for row in terminal.scrolled if re.search("processes:|logs counter|q back", row)
    ]


@pytest.mark.thorough
def test_pastes_and_unknown_keys_are_no_commands(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    open_picker(terminal)
    terminal.type("\x1b[200~kill\nstop\rsrkmo\x1b[201~")
    terminal.type("\x1bOk")  # `+` of a keypad
    terminal.type(f"\x1bs{DOWN}")  # Alt-s
    terminal.wait_until(lambda: chosen(terminal).startswith(">2 robot_2-2  running"), "an arrow")
    terminal.type("/")
    terminal.type("\x1b[200~robot_2\nkill\x1b[201~")
    terminal.wait_until(lambda: "processes: 1  /robot_2" in terminal.rows, "a search")
    terminal.type("\x0c")
    terminal.wait_until(lambda: "processes: 1  /robot_2" in terminal.rows, "the same after Ctrl-L")
    terminal.type("\x04")  # of a search as of a list: no end of the run
    terminal.type(ENTER + "q")
    wait_until_closed(terminal)
    assert not any(re.match(r"> (kill|stop|start|restart|mute|solo)", r) for r in terminal.scrolled)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_ctrl_z_and_fg_bring_the_picker_back(bench: Bench):
    words = " ".join(bench.command(TICKS))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words}\n")
        open_picker(shell)
        shell.type(DOWN)
        for _ in range(2):
            shell.wait_until(lambda: "robot_2-2" in chosen(shell), "the second")
            shell.type("\x1a")
            shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the shell's prompt")
            assert OPEN not in shell.text
            assert not shell.cursor_is_hidden
            shell.type("stty -a | grep -o ' icanon'\n")
            shell.wait_until(lambda: " icanon" in shell.rows, "cooked mode")
            shell.type("clear; fg\n")
        shell.wait_until(lambda: "robot_2-2" in chosen(shell), "the second again")
        shell.type("q")
        wait_until_closed(shell)
        shell.enter("quit")
        shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the end")
        assert not shell.cursor_is_hidden


FLOOD = """
        py("n = 0\\nwhile True: print(f'{n:08}', 'x' * 60, flush=True); n += 1", name="flood"),
        py("input()", name="quiet"),
"""


def lines_of_log(terminal: ScreenTerminal) -> int:
    return sum(bool(re.match(r"\d{8} x", row)) for row in terminal.rows)


@pytest.mark.thorough
def test_a_slow_terminal_still_obeys_the_picker(bench: Bench):
    terminal = bench.screen_terminal(FLOOD, columns=80, rows=20)
    terminal.bytes_per_s = 200_000.0
    terminal.wait_for_prompt(300.0)  # what was written before it takes the emulator long
    open_picker(terminal)
    terminal.type(ENTER)
    terminal.wait_until(lambda: "logs flood-1: running, following" in terminal.rows, "the log")
    terminal.wait_until(lambda: lines_of_log(terminal) == 13, "its lines")
    terminal.type(PAGE_UP)
    terminal.wait_until(lambda: "following" not in terminal.text, "a place")
    terminal.type("q")
    terminal.wait_until(lambda: OPEN in terminal.text, "the list")
    terminal.type("m")
    terminal.wait_for("| flood-1 is muted")
    terminal.wait_until(lambda: "mute flood  hidden " in terminal.text, "the filter")
    terminal.type(ENTER)  # now the terminal is not what slows the process down
    terminal.wait_until(lambda: "logs flood-1: running, following" in terminal.rows, "the log")
    terminal.wait_until(lambda: lines_of_log(terminal) == 13, "its lines")
    for _ in range(3):
        terminal.type(PAGE_UP)
        terminal.wait_until(lambda: "following" not in terminal.text, "a place")
        terminal.type("\x1b[F")
        terminal.wait_until(lambda: "following" in terminal.text, "the end")
    terminal.type("s")
    terminal.wait_for("| flood-1 stopped in ")
    terminal.ctrl_c()
    wait_until_closed(terminal)
    terminal.ctrl_c()
    terminal.exit_code()


@pytest.mark.thorough
def test_a_run_that_ends_while_the_picker_is_open_leaves_a_whole_terminal(
    bench: Bench,
):
    terminal = bench.screen_terminal(TICKS)
    open_picker(terminal)
    terminal.wait_until(lambda: terminal.cursor_is_hidden, "no cursor")
    terminal.kill(signal.SIGINT)  # the verb quit would wait for the end, and nobody reads meanwhile
    assert terminal.exit_code() == 0
    assert terminal.settings() == terminal.untouched
    assert not terminal.cursor_is_hidden
    assert OPEN not in terminal.text
    assert bench.survivors() == []
