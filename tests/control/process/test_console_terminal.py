"""When the console starts, and how it restores the terminal: job control, crashes, resizing."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from tests.support.benches import Bench
from tests.support.screen_terminal import ScreenTerminal
from tests.support.waiting import wait_until

TICKS = """
        py("import time\\nwhile True: print('tick', flush=True); time.sleep(0.05)", name="ticker"),
"""

LATER = """
        TimerAction(period=1.0, actions=[LogInfo(msg="later than a console would start")]),
"""

# Enlarges pipes, which the command inherits, until its user has reached the limit of the kernel.
FULL = """
import fcntl, os, sys
try:
    while True:
        ends = os.pipe()
        for end in ends:
            os.set_inheritable(end, True)
        fcntl.fcntl(ends[0], fcntl.F_SETPIPE_SZ, 1 << 20)
except PermissionError:
    os.execvp(sys.argv[1], sys.argv[1:])
"""


def consoles_of(launcher: int) -> list[psutil.Process]:
    children = psutil.Process(launcher).children()
    return [child for child in children if "launcher.control.console" in child.cmdline()]


def console_of(launcher: int) -> psutil.Process:
    (console,) = consoles_of(launcher)
    return console


# ---- who gets one


def test_no_console_is_started_if_it_is_disabled(bench: Bench):
    terminal = bench.screen_terminal(TICKS + LATER, "--no-console")
    terminal.wait_for("later than a console would start")
    assert consoles_of(terminal.pid) == []
    assert terminal.settings() == terminal.untouched
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_the_console_starts_where_no_pipe_may_be_enlarged(bench: Bench):
    is_root = os.geteuid() == 0
    unprivileged = ["setpriv", "--bounding-set=-sys_admin,-sys_resource"] if is_root else []
    command = bench.command(TICKS)
    bench.command = lambda *words: [*unprivileged, sys.executable, "-c", FULL, *command]  # type: ignore[method-assign]
    terminal = bench.screen_terminal("")
    terminal.wait_for_prompt()
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_a_dumb_terminal_gets_no_console(bench: Bench):
    bench.env["TERM"] = "dumb"
    terminal = bench.screen_terminal(TICKS + LATER)
    terminal.wait_for("later than a console would start")
    assert consoles_of(terminal.pid) == []
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_without_a_terminal_on_both_sides_there_is_no_console(bench: Bench):
    command = bench.command(TICKS + LATER)
    ours, theirs = pty.openpty()
    for stdin, stdout in ((theirs, subprocess.PIPE), (subprocess.DEVNULL, theirs)):
        launcher = subprocess.Popen(command, env=bench.env, stdin=stdin, stdout=stdout)
        source = ours if launcher.stdout is None else launcher.stdout.fileno()
        seen = b""
        while b"later than a console" not in seen:
            seen += os.read(source, 4096)
        assert consoles_of(launcher.pid) == []
        assert b"\x1b[?" not in seen
        launcher.send_signal(signal.SIGINT)
        wait_until(lambda one=launcher: one.poll() is not None, "the end")
        if launcher.stdout is not None:
            launcher.stdout.close()
    os.close(ours)
    os.close(theirs)


@pytest.mark.thorough
def test_a_run_in_the_background_leaves_the_terminal_alone(bench: Bench):
    words = " ".join(bench.command(TICKS + LATER))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words} &\n")
        shell.wait_for("later than a console would start")
        (launcher,) = psutil.Process(shell.pid).children()
        assert consoles_of(launcher.pid) == []
        launcher.send_signal(signal.SIGTERM)
        wait_until(lambda: not launcher.is_running(), "the end")


# ---- whatever happens


def test_a_killed_launcher_leaves_the_terminal_as_it_was_and_says_so(bench: Bench):
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    terminal.type("half a li")
    terminal.wait_until(lambda: "> half a li" in terminal.text, "what is typed")
    terminal.kill(signal.SIGKILL)
    terminal.wait_for("[ERROR] [console]: the launcher was killed")
    wait_until(lambda: bench.survivors() == [], "nothing is left")
    assert terminal.exit_code() == -signal.SIGKILL  # with all that was shown
    assert terminal.settings() == terminal.untouched
    assert not terminal.cursor_is_hidden
    assert "half a li" not in terminal.text


@pytest.mark.thorough
def test_a_shell_can_be_used_after_its_launcher_was_killed(bench: Bench):
    words = " ".join(bench.command(TICKS))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words}\n")
        shell.wait_for_prompt()
        (launcher,) = psutil.Process(shell.pid).children()
        launcher.kill()
        shell.wait_for("Killed", "the launcher was killed")
        shell.type("stty -a | grep -o ' icanon'; echo 'st''ill here'\n")
        shell.wait_for("still here")
        assert " icanon" in shell.scrolled


COUNTER = """
        py("import time\\ninput()\\n"
           "for n in range(400): print(n, flush=True); time.sleep(0.005)\\n"
           "input()", name="counter"),
"""


@pytest.mark.thorough
@pytest.mark.parametrize("signum", [signal.SIGKILL, signal.SIGSEGV], ids=lambda one: one.name)
def test_a_killed_console_causes_one_warning_and_loses_no_line(
    bench: Bench, signum: signal.Signals
):
    terminal = bench.screen_terminal(COUNTER)
    terminal.wait_for_prompt()
    console = console_of(terminal.pid)
    console.suspend()  # what it has read and not shown would be lost
    bench.ask_run(terminal.pid, "send", "counter", "go")
    log = bench.folder / "log/latest/counter-1.log"
    wait_until(lambda: log.exists() and "] 99\n" in log.read_text(), "it counts")
    console.send_signal(signum)
    if signum != signal.SIGKILL:
        console.resume()  # it dies of the other one then, and before it does anything else
    terminal.wait_for(f"[launch]: the console died ({signum.name}); the run continues without one")
    terminal.wait_until(lambda: any(row.endswith("] 399") for row in terminal.scrolled), "the last")
    assert terminal.settings() == terminal.untouched
    assert not terminal.cursor_is_hidden
    numbers = [
        row.rpartition(" ")[2]
        for row in terminal.scrolled
        if "[counter" in row and "INFO" not in row
    ]
    assert [n for n in numbers if n.isdecimal()] == [str(n) for n in range(400)]
    assert sum("the console died" in row for row in terminal.scrolled) == 1
    terminal.ctrl_c()  # is the terminal's own again
    assert terminal.exit_code() == 0
    assert bench.survivors() == []


@pytest.mark.thorough
def test_a_console_that_cannot_start_causes_one_warning(bench: Bench, tmp_path: Path):
    broken = tmp_path / "broken" / "prompt_toolkit"
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text("raise ImportError('no such terminal')")
    bench.env["PYTHONPATH"] = str(broken.parent)
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for("the console died (exit code 1): ImportError: no such terminal")
    assert terminal.settings() == terminal.untouched
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


FLOOD = """
        py("input()\\nfor n in range(25000): print(f'{n:05}', 'x' * 60)\\ninput()", name="flood"),
"""


@pytest.mark.thorough
def test_a_stopped_console_holds_the_run_up_and_loses_nothing(bench: Bench):
    terminal = bench.screen_terminal(FLOOD)
    terminal.wait_for_prompt()
    console = console_of(terminal.pid)
    (flood,) = (c for c in psutil.Process(terminal.pid).children() if "input()" in c.cmdline()[-1])
    terminal.emulates = False
    terminal.enter("send flood go")
    terminal.wait_until(lambda: b" 00000 x" in terminal.raw, "the first line")
    console.suspend()
    wait_until(lambda: flood.status() == psutil.STATUS_SLEEPING, "it waits for room")
    console.resume()
    terminal.wait_until(lambda: b" 24999 x" in terminal.raw[-8192:], "the last line", 60.0)
    terminal.ctrl_c()
    terminal.exit_code()
    numbers = re.findall(rb"\[flood-1\]\S* (\d{5}) x{60}\r\n", terminal.raw)
    assert numbers == [b"%05d" % n for n in range(25000)]


FAULT = """
import os, sys, threading, time

def strike():
    while not os.path.exists("{go}"): time.sleep(0.02)
    import launcher.control.console.console_session as session
    def broken(*_, **__): raise ZeroDivisionError("a broken bar")
    session.status_lines = broken

if "launcher.control.console" in sys.orig_argv:
    threading.Thread(target=strike, daemon=True).start()
"""


@pytest.mark.thorough
def test_a_fault_in_the_console_gives_the_terminal_back(bench: Bench, tmp_path: Path):
    folder = tmp_path / "fault"
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(FAULT.replace("{go}", f"{folder}/go"))
    bench.env["PYTHONPATH"] = str(folder)
    terminal = bench.screen_terminal(TICKS)
    terminal.wait_for_prompt()
    (folder / "go").touch()
    terminal.wait_for("the console died (exit code 1): ZeroDivisionError: a broken bar")
    assert terminal.settings() == terminal.untouched
    assert terminal.prompt_row == -1
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_a_run_that_ends_before_its_console_is_ready_does_not_mention_it(bench: Bench):
    terminal = bench.screen_terminal('py("import time\\ntime.sleep(0.4)", name="short"),')
    assert terminal.exit_code() == 0
    assert terminal.settings() == terminal.untouched
    assert "console" not in terminal.text
    assert bench.survivors() == []


def test_a_closed_window_stops_the_run_in_order(bench: Bench, tmp_path: Path):
    said = tmp_path / "said"
    polite = (
        "py(\"import time\\ntry:\\n print('ready', flush=True)\\n while True: time.sleep(0.1)\\n"
        "except KeyboardInterrupt: "
        f"open('{said}', 'w').write('bye')\", name='polite', sigterm_timeout='600'),"
    )
    terminal = bench.screen_terminal(polite)
    terminal.wait_for_prompt()
    terminal.wait_for("[polite-1] ready")
    terminal.close_window()
    wait_until(lambda: bench.survivors() == [], "nothing is left")
    assert said.read_text() == "bye"


# ---- suspended, resized


def test_ctrl_z_gives_the_terminal_back_and_fg_takes_it_again(bench: Bench):
    words = " ".join(bench.command(TICKS))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words}\n")
        shell.wait_for_prompt()
        shell.type("\x1a")
        shell.wait_for("Stopped")
        shell.type("stty -a | grep -o ' icanon'\n")
        shell.wait_until(lambda: any(row == " icanon" for row in shell.rows), "cooked mode")
        shell.type("fg\n")
        shell.wait_until(lambda: shell.rows[shell.prompt_row].rstrip() == ">", "the prompt")
        shell.enter("ps")
        shell.wait_for("ticker-1  running")
        shell.ctrl_c()
        shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the shell's prompt")
        shell.type("echo exit code $?\n")
        shell.wait_for("exit code 0")


ASKS = """
        py("input()\\nprint('Name? ', end='', flush=True)\\ninput()", name="asker"),
"""


@pytest.mark.thorough
def test_unfinished_input_and_output_appear_once_after_ctrl_z_and_fg(bench: Bench):
    words = " ".join(bench.command(ASKS))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words}\n")
        shell.wait_for_prompt()
        shell.enter("send asker go")
        shell.type("half a li")
        shell.wait_until(lambda: "[asker-1] Name?" in shell.rows, "the question")
        shell.wait_until(lambda: "> half a li" in shell.rows, "what is typed")
        for _ in range(3):
            shell.type("\x1a")
            shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the shell's prompt")
            shell.type("clear; fg\n")
            shell.wait_until(lambda: "> half a li" in shell.rows, "the prompt")
            shell.wait_until(lambda: shell.below_prompt(1).startswith("asker"), "the bar")
        shell.wait_until(
            lambda: shell.rows.count("[asker-1] Name?") == shell.rows.count("> half a li") == 1,
            "each once",
        )
        shell.wait_until(
            lambda: shell.rows[shell.prompt_row - 1] == "[asker-1] Name?",
            "the question above the prompt",
        )
        shell.ctrl_c()
        shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the end")


@pytest.mark.thorough
def test_bg_goes_on_without_a_prompt_and_fg_brings_it_back(bench: Bench):
    words = " ".join(bench.command(TICKS))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words}\n")
        shell.wait_for_prompt()
        shell.type("\x1a")
        shell.wait_for("Stopped")
        shell.type("clear; bg\n")
        shell.wait_until(lambda: shell.text.count("] tick") > 19, "lines go on")
        assert shell.prompt_row == -1
        shell.type("fg\n")
        shell.wait_for_prompt()
        shell.enter("quit")
        shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the shell's prompt")
        shell.type("echo exit code $?\n")
        shell.wait_for("exit code 0")


@pytest.mark.thorough
def test_a_job_stopped_from_outside_redraws_its_prompt_in_the_foreground(bench: Bench):
    words = " ".join(bench.command(TICKS))
    with ScreenTerminal(["bash", "--norc", "-i"], env=bench.env) as shell:
        shell.type(f"PS1='$ '; {words}\n")
        shell.wait_for_prompt()
        (launcher,) = psutil.Process(shell.pid).children()
        os.killpg(launcher.pid, signal.SIGSTOP)
        shell.wait_for("Stopped")
        shell.type("clear; fg\n")
        shell.wait_until(
            lambda: "Stopped" not in shell.text and shell.prompt_row > 0, "the prompt again"
        )
        shell.enter("ps")
        shell.wait_for("ticker-1  running")
        shell.ctrl_c()
        shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the shell's prompt")
        shell.type("echo exit code $?\n")
        shell.wait_for("exit code 0")


SIZE = """
        py("import os, signal, time\\n"
           "tell = lambda *_: print('size', *os.get_terminal_size(), flush=True)\\n"
           "signal.signal(signal.SIGWINCH, tell)\\ntell()\\n"
           "while True: time.sleep(1)", name="sizer", emulate_tty=True),
"""


def test_a_resized_window_is_redrawn_and_the_processes_are_notified(bench: Bench):
    terminal = bench.screen_terminal(SIZE, columns=100, rows=24)
    terminal.wait_for("size 90 24")  # less the prefix
    terminal.wait_for_prompt()
    terminal.type("half a li")
    terminal.resize(60, 15)
    terminal.wait_for("size 50 15")
    terminal.wait_until(lambda: "> half a li" in terminal.text, "the prompt")
    terminal.wait_until(lambda: sum(r.startswith(">") for r in terminal.rows) == 1, "one prompt")
    terminal.resize(120, 30)
    terminal.wait_for("size 110 30")
    terminal.wait_until(lambda: terminal.below_prompt(1).startswith("sizer "), "the bar")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
