"""Control commands from another shell: ps, logs, events, top and exit codes."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys

import psutil
import pytest

from launcher.cli.dispatch import CONTROL_VERBS
from tests.support.benches import ControlBench
from tests.support.controlled_run import TIMEOUT_S
from tests.support.screen_terminal import ScreenTerminal
from tests.support.waiting import wait_until

CAT = 'sh("exec cat", name="cat")'
TOP = [sys.executable, "-m", "launcher", "top"]


def words_of(table: str) -> list[list[str]]:
    return [line.split() for line in table.splitlines()]


def test_ps_is_a_table_for_people_and_an_object_for_programs(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        pid = str(run.row("cat")["pid"])
        head, row = words_of(run.shell("ps").stdout)
        assert head[:3] == ["name", "state", "pid"]
        assert row[:3] == ["cat-1", "running", pid]
        (found,) = json.loads(run.shell("ps", "--json").stdout)["processes"]
        assert found["pid"] == int(pid)
        run.shell("mute", "cat")
        shown = run.shell("ps", "cat").stdout
        assert "muted" in shown and "0 lines" not in shown


def test_each_command_tells_what_happened(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        done = run.shell("stop", "cat")
        assert re.fullmatch(r"cat-1 stopped in \d\.\d\d s \(SIGINT\)\n", done.stdout)
        assert run.shell("start", "cat").stdout.startswith("cat-1 started with pid ")
        assert run.shell("level", "WARN").stdout == "cat-1 shows WARN and above\n"
        assert run.shell("unmute").stdout == (
            "cat-1 was not muted; `level WARN` still hides lines\n"
        )
        assert re.search(r"^command +sh -c 'exec cat'$", run.shell("info", "cat").stdout, re.M)
        done = run.shell("quit")
        assert (
            done.stdout == "the run is being stopped: 1 process still running\nthe run has ended\n"
        )
        assert run.exit_code() == 0


def test_a_text_with_dashes_goes_to_the_process_as_it_is(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        assert run.shell("send", "cat", "-n", "--", "--json", "it's").returncode == 0
        run.wait_for("[cat-1] -n --json it's\n")
        pid = str(run.process.pid)
        assert run.shell("send", "cat", "its own run", "--run", pid).returncode == 0
        run.wait_for("[cat-1] its own run\n")


def test_failures_exit_with_1_and_usage_errors_with_2(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        unknown = run.shell("stop", "cta")
        assert unknown.returncode == 1
        assert unknown.stderr == (
            "error: unknown process 'cta'\nhint: did you mean 'cat-1'? known: cat-1\n"
        )
        bad_values = ["kill", "cat", "-s", "NO"], ["level", "foo"], ["grep", "("]
        for words in (["stop"], *bad_values, ["ps", "-x"], ["ps", "--run"]):
            wrong = run.shell(*words)
            assert wrong.returncode == 2, words
            assert wrong.stderr.startswith("error: ")
        assert run.shell("stop", "cat").returncode == 0
        assert run.shell("stop", "cat").returncode == 1


@pytest.mark.thorough
def test_commands_without_a_run_say_so(control_bench: ControlBench):
    with control_bench.launch('sh("true")', "--no-control") as run:
        run.exit_code()
        done = run.shell("ps")
        assert done.returncode == 1
        assert "no active run" in done.stderr
        assert run.shell("runs").stdout == "no active run\n"
        assert json.loads(run.shell("runs", "--json").stdout) == {"version": 1, "runs": []}


def test_logs_are_followed_until_ctrl_c(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        run.ask_text("send", "cat", text="before")
        run.wait_for_log("cat", "before")
        follower = run.shell_start("logs", "-f", "-n", "1", "cat")
        assert follower.stdout.readline() == "[cat-1] before\n"
        run.ask_text("send", "cat", text="after")
        assert follower.stdout.readline() == "[cat-1] after\n"
        follower.send_signal(signal.SIGINT)
        assert follower.wait(TIMEOUT_S) == 0
        assert follower.stderr.read() == ""


def test_events_are_followed_to_the_end_of_the_run(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        follower = run.shell_start("events", "-f", "--json")
        assert json.loads(follower.stdout.readline())["event"] == "started"
        run.ask_text("quit")
        events = [json.loads(line)["event"] for line in follower.stdout]
        assert events[-1] == "finished"
        assert follower.wait(TIMEOUT_S) == 0


def test_events_are_lines_for_people(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        pid = run.row("cat")["pid"]
        first = run.shell("events").stdout.splitlines()[0]
        assert re.fullmatch(rf"\d\d:\d\d:\d\d started cat-1 pid={pid} restarts=0", first)


def test_a_signal_that_a_user_has_sent_is_named_for_people_and_a_number_for_programs(
    control_bench: ControlBench,
):
    command = "trap 'echo heard' USR1; echo begun; while :; do sleep 0.1; done"
    with control_bench.launch(f'sh({command!r}, name="it")') as run:
        run.wait_for("[it-1] begun")
        pid = run.row("it")["pid"]
        followers = [run.shell_start("events", "-f", *words) for words in ((), ("--json",))]
        heads = [follower.stdout.readline() for follower in followers]
        for signum in ("USR1", "34"):  # 34 is SIGRTMIN, by which the process ends
            assert run.shell("kill", "-s", signum, "it").returncode == 0
        lines = run.shell("events").stdout.splitlines()
        entries = [json.loads(one) for one in run.shell("events", "--json").stdout.splitlines()]
        run.ask_text("quit")
        told, documents = (follower.communicate(timeout=TIMEOUT_S)[0] for follower in followers)
        assert [follower.returncode for follower in followers] == [0, 0]
    assert " started it-1 " in heads[0] and json.loads(heads[1])["event"] == "started"
    sent = "requested it-1 verb=kill signal=SIGUSR1", f"signal it-1 pid={pid} signal=SIGUSR1"
    for text in (*sent, "requested it-1 verb=kill signal=SIGRTMIN"):
        assert any(one.endswith(f" {text}") for one in lines), lines
        assert f" {text}\n" in told
    asked = [one for one in entries if one["event"] == "asked"]
    assert [one["signal"] for one in asked] == [signal.SIGUSR1, 34]
    assert all(one in map(json.loads, documents.splitlines()) for one in asked)


def test_top_is_drawn_again_scrolls_and_leaves_the_terminal_as_it_was(control_bench: ControlBench):
    many = "".join(f'sh("exec cat", name="cat_{n}"),' for n in range(12))
    with control_bench.launch(many) as run:
        assert run.socket
        env = {**run.env, "TERM": "xterm-256color"}
        with ScreenTerminal([*TOP, "-p", "0.1"], env=env, columns=60, rows=8) as terminal:
            terminal.type("n")
            terminal.wait_until(
                lambda: "1-5 of 12 by name: 7 more below" in terminal.rows, "a part"
            )
            terminal.wait_until(lambda: terminal.rows[1].startswith("cat_0-1"), "the first row")
            terminal.type("\x1b[F")
            terminal.wait_until(lambda: terminal.rows[5].startswith("cat_11-12"), "the last")
            run.ask_text("pause", "cat_11")
            terminal.wait_until(lambda: "paused" in terminal.rows[5], "another look")
            terminal.resize(40, 12)
            terminal.wait_until(lambda: "4-12 of 12 by name: 3 more above" in terminal.rows, "more")
            terminal.type("q")
            assert terminal.exit_code() == 0
            assert terminal.settings() == terminal.untouched
            assert not terminal.cursor_is_hidden
        with ScreenTerminal(TOP, env=env) as terminal:
            terminal.wait_until(lambda: "12 by cpu" in terminal.rows, "the table")
            terminal.ctrl_c()
            assert terminal.exit_code() == 0


@pytest.mark.thorough
def test_top_gives_the_terminal_back_when_it_is_suspended_or_terminated(
    control_bench: ControlBench,
):
    with control_bench.launch(CAT) as run:
        assert run.socket
        env = {**run.env, "TERM": "xterm-256color"}
        with ScreenTerminal(["bash", "--norc", "-i"], env=env) as shell:
            shell.type(f"PS1='$ '; {' '.join(TOP)}\n")
            shell.wait_until(lambda: "1 by cpu" in shell.rows, "the table")
            shell.type("\x1a")
            shell.wait_for("Stopped")
            shell.type("stty -a | grep -o ' icanon'\n")
            shell.wait_until(lambda: " icanon" in shell.rows, "cooked mode")
            shell.type("clear\n")
            shell.wait_until(lambda: "1 by cpu" not in shell.rows, "an empty screen")
            shell.type("fg\n")
            shell.wait_until(lambda: "1 by cpu" in shell.rows, "the table again")
            (top,) = psutil.Process(shell.pid).children()
            top.terminate()
            shell.wait_until(lambda: shell.rows[shell.cursor[0]] == "$", "the shell's prompt")
            shell.type("stty -a | grep -c ' icanon'\n")
            shell.wait_until(lambda: "1" in shell.rows, "cooked mode")


@pytest.mark.thorough
def test_top_through_a_pipe_is_one_table_with_the_busiest_first(control_bench: ControlBench):
    busy = 'sh("while :; do :; done", name="busy")'
    with control_bench.launch(f"{CAT}, {busy}") as run:
        wait_until(lambda: run.row("busy")["cpu_percent"], "its share is known")
        _, first, second = words_of(run.shell("top").stdout)
        assert [first[0], second[0]] == ["busy-2", "cat-1"]


def test_top_through_a_pipe_ends_with_the_run(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        follower = run.shell_start("top", "--json", "-p", "0.1")
        assert json.loads(follower.stdout.readline())["processes"][0]["name"] == "cat-1"
        run.ask_text("quit")
        follower.stdout.read()
        assert follower.wait(TIMEOUT_S) == 0


def test_a_process_of_a_run_means_its_own_run(control_bench: ControlBench):
    with control_bench.launch('sh("exec cat", name="one")') as one:
        assert one.row("one")["pid"]
        asker = f'sh("read go; {sys.executable} -m launcher ps --json; exec cat", name="asker")'
        with control_bench.launch(asker) as two:
            two.ask_text("send", "asker", text="go")
            two.wait_for('"name": "asker-1"')
            assert '"name": "one-1"' not in two.screen


@pytest.mark.thorough
@pytest.mark.parametrize("verb", CONTROL_VERBS)
def test_every_command_has_help(control_bench: ControlBench, verb: str):
    done = subprocess.run(
        [sys.executable, "-m", "launcher", verb, "--help"],
        capture_output=True,
        text=True,
        check=True,
        timeout=TIMEOUT_S,
    )
    assert done.stdout.startswith(f"usage: python -m launcher {verb}")


@pytest.mark.thorough
def test_help_explains_a_verb_and_typos_get_a_suggestion(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        manual = run.shell("kill", "--help").stdout
        assert manual.startswith("usage: python -m launcher kill NAME")
        assert run.shell("help", "kill").stdout == manual
        assert run.shell("help").stdout == run.shell("--help").stdout
        early = run.shell("--run", run.socket.stem, "ps")
        assert early.returncode == 2 and "--run is an option of a verb" in early.stderr
        silent = run.shell("send", "cat")
        assert "send needs TEXT: a line for its standard input" in silent.stderr
        assert "did you mean" not in run.shell("bogus").stderr
        assert "did you mean `python -m launcher start`?" in run.shell("strat").stderr
        assert "the name of the launch file is empty" in run.shell("").stderr
        for words in (("-9", "cat"), ("-KILL", "cat")):
            assert run.shell("kill", *words).stdout.startswith("cat-1 ended in ")
            run.shell("start", "cat")


COLOURFUL = """py("for i in range(30): print(f'\\x1b[33mline {i}\\x1b[0m', flush=True)\\n"
     "import signal; signal.pause()", name="lines"),"""


def test_logs_have_no_colours_in_a_pipe_and_begin_with_ten_lines_if_followed(
    control_bench: ControlBench,
):
    with control_bench.launch(COLOURFUL) as run:
        run.wait_for_log("lines", "line 29")
        assert run.shell("logs", "lines").stdout.splitlines()[-30:] == [
            f"[lines-1] line {number}" for number in range(30)
        ]
        followed = run.shell_start("logs", "-f", "lines")
        assert followed.stdout is not None
        assert followed.stdout.readline() == "[lines-1] line 20\n"
        followed.send_signal(signal.SIGINT)
        followed.communicate(timeout=TIMEOUT_S)
        run.env["RCUTILS_COLORIZED_OUTPUT"] = "1"
        assert "\x1b[33mline 29" in run.shell("logs", "lines").stdout


def test_the_plan_of_the_running_launch_needs_no_target(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        assert "cat-1" in run.shell("plan").stdout
        assert json.loads(run.shell("plan", "--json").stdout) == run.ask("plan")
        assert run.shell("plan", "--run", "bogus").stderr.startswith("error: unknown run 'bogus'")
        assert run.shell("plan", "x.launch.py", "--run", "bogus").returncode == 2


def test_the_files_of_a_run_are_offered_after_its_end(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        with run.connect() as connection:
            folder = connection.hello["run"]["log_dir"]
        run.shell("send", "cat", "a line")
        run.wait_for_log("cat", "a line")
        run.shell("quit")
        assert run.exit_code() == 0
        for words, file in (
            (["logs"], "launch.log"),
            (["logs", "cat"], "cat-1.log"),
            (["logs", "bogus"], "launch.log"),
            (["events"], "events.jsonl"),
        ):
            hint = f"hint: files of the last run:\n  {folder}/{file}\n"
            assert run.shell(*words).stderr == f"error: no active run\n{hint}"
        assert f"the plan of the last run: {folder}/plan.json\n" in run.shell("plan").stderr
        assert run.shell("ps").stderr.startswith("error: no active run\nhint: start one with")
