"""Output, messages and exit code of runs."""

from __future__ import annotations

import json
import re
import shlex
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.support.benches import Bench, ControlBench
from tests.support.waiting import wait_until


def test_a_clean_run_says_what_ros2_launch_says_and_exits_with_0(bench: Bench):
    done = bench.run('sh("echo hello; echo there >&2")')
    out = done.stdout.decode()
    assert done.returncode == 0
    assert re.search(r"^\[INFO\] \[launch\]: All log files can be found below ", out, re.M)
    assert re.search(r"^\[INFO\] \[sh-1\]: process started with pid \[\d+\]$", out, re.M)
    assert "[sh-1] hello\n[sh-1] there\n" in out
    assert re.search(r"^\[INFO\] \[sh-1\]: process has finished cleanly \[pid \d+\]$", out, re.M)


def test_a_failed_process_is_reported_with_its_code_and_fails_the_run(bench: Bench):
    done = bench.run('sh("echo hello; exit 3"), sh("kill -SEGV $$")')
    out = done.stdout.decode()
    assert done.returncode == 1
    death = r"process has died \[pid \d+, exit code 3, cmd 'sh -c echo hello; exit 3'\]\."
    died = rf"^\[ERROR\] \[sh-1\]: {death}$"
    assert re.search(died, out, re.M)
    assert re.search(r"process has died \[pid \d+, exit code -11, cmd ", out)


def test_a_start_without_byte_code_says_so_in_an_idle_moment(bench: Bench):
    bench.env |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPYCACHEPREFIX": f"{bench.folder}/none"}
    told = "until grep -q 'at every start, since P' $ROS_LOG_DIR/launch.log; do sleep 0.05; done"
    done = bench.run(f'sh("{told}")')
    assert done.returncode == 0
    assert done.stdout.decode().count("[INFO] [launch]: Python compiles launcher") == 1


def test_a_missing_program_is_reported_and_the_others_run_on(bench: Bench):
    done = bench.run('ExecuteProcess(cmd=["/no/such/program"]), sh("echo hello")')
    out = done.stdout.decode()
    assert done.returncode == 1
    assert "[ERROR] [program-1]: process could not be started: No such file or directory" in out
    assert "[sh-2] hello\n" in out


def test_the_output_of_a_process_comes_before_the_report_of_its_exit(bench: Bench):
    done = bench.run('sh("seq 2000; printf last")')
    lines = done.stdout.decode().splitlines()
    assert lines.index("[sh-1] last") < lines.index(next(x for x in lines if "finished" in x))
    assert [f"[sh-1] {n}" for n in range(1, 2001)] == [x for x in lines if re.match(r".* \d+$", x)]


def test_stdout_and_stderr_keep_the_order_in_which_they_were_written(bench: Bench):
    done = bench.run('sh("for i in 1 2 3; do echo out $i; echo err $i >&2; done")')
    shown = [x for x in done.stdout.decode().splitlines() if re.search("(out|err) .$", x)]
    assert shown == [f"[sh-1] {stream} {n}" for n in (1, 2, 3) for stream in ("out", "err")]


def test_python_children_are_not_buffered_although_they_write_to_a_pipe(bench: Bench):
    process = bench.start("py(\"print('early'); input()\")")
    assert process.stdout is not None
    lines = iter(process.stdout.readline, b"")
    assert any(line == b"[python-1] early\n" for line in lines)
    process.terminate()
    process.communicate(timeout=60)


def test_emulate_tty_gives_a_terminal_and_plain_newlines(bench: Bench):
    script = "import sys; print(sys.stdout.isatty(), sys.stderr.isatty(), sys.stdin.isatty())"
    done = bench.run(f'py("{script}", emulate_tty=True)')
    assert b"[python-1] True True False\n" in done.stdout


def test_a_prompt_is_shown_before_its_newline_and_its_line_is_completed(bench: Bench):
    # The console, tried elsewhere, draws it again above its prompt.
    terminal = bench.terminal("sh(\"printf 'name? '; sleep 0.5; echo bob\")", "--no-console")
    assert terminal.exit_code() == 0
    assert "[sh-1] name? bob\n" in terminal.text
    assert terminal.text.count("name?") == 1


def test_output_log_hides_stdout_shows_stderr_and_keeps_both_in_the_file(bench: Bench):
    done = bench.run('sh("echo to stdout; echo to stderr >&2", output="log")')
    assert b"to stdout" not in done.stdout
    assert b"[sh-1] to stderr\n" in done.stdout
    log = (bench.folder / "log" / "latest" / "launch.log").read_text()
    assert re.search(r"^\d+\.\d{7} \[sh-1\] to stdout$", log, re.M)
    assert re.search(r"^\d+\.\d{7} \[sh-1\] to stderr$", log, re.M)


def test_a_log_folder_that_cannot_be_created_is_replaced_by_another(bench: Bench):
    (bench.folder / "log").write_text("a file where a folder should be")
    done = bench.run('sh("echo hello; echo $ROS_LOG_DIR")')
    assert done.returncode == 0
    (found,) = (bench.folder / "state").glob("ros-launcher-*/log/latest")
    folder = str(found.resolve())
    assert f"[sh-1] hello\n[sh-1] {folder}\n" in done.stdout.decode()
    warning = (
        f"warning: cannot write to the log folder {bench.folder}/log (Not a directory): logs go to"
    )
    assert done.stderr.decode() == f"{warning} {found.parent}; ROS_LOG_DIR chooses another\n"
    assert b"no log files" not in done.stdout


@pytest.mark.thorough
def test_colour_is_off_in_a_pipe_and_on_by_force(bench: Bench):
    actions = 'sh("echo $RCUTILS_COLORIZED_OUTPUT")'
    assert b"[sh-1] 0\n" in bench.run(actions).stdout
    bench.env["FORCE_COLOR"] = "1"
    assert re.search(rb"\x1b\[38;5;\d+m\[sh-1\]\x1b\[0m 1\n", bench.run(actions).stdout)
    bench.env["NO_COLOR"] = "1"
    assert b"\x1b" not in bench.run(actions).stdout


def test_a_process_with_an_environment_of_its_own_gets_only_that_and_the_run_id(bench: Bench):
    actions = """
        ExecuteProcess(cmd=["/usr/bin/env"], name="given", env={"A": "1"}, output="screen"),
        ReplaceEnvironmentVariables({"A": "1", "PATH": "/usr/bin"}),
        ExecuteProcess(cmd=["env"], name="replaced", output="screen"),
    """
    out = bench.run(actions).stdout

    names = {
        label: {m[1] for m in re.finditer(rb"\[%s-\d\] (\w+)=" % label, out)}
        for label in (b"given", b"replaced")
    }
    assert names == {
        b"given": {b"A", b"LAUNCHER_RUN_ID"},
        b"replaced": {b"A", b"PATH", b"LAUNCHER_RUN_ID"},
    }


def test_a_respawned_process_runs_again_as_often_as_it_may(bench: Bench):
    done = bench.run('sh("echo run; exit 1", respawn=True, respawn_max_retries=2)')
    assert done.stdout.count(b"[sh-1] run\n") == 3
    assert b"[ERROR] [sh-1]: process is given up after 2 restarts" in done.stdout
    assert done.returncode == 1


def test_clean_exits_that_are_restarted_as_asked_are_no_deaths(bench: Bench):
    done = bench.run('sh("exit 0", respawn=True, respawn_max_retries=2)')
    out = done.stdout.decode()
    assert "[INFO] [sh-1]: process is not restarted again after 2 restarts\n" in out
    assert re.search(r"\n    sh-1 +exited 3x: exit code 0, restarts used up +2 ", out)
    assert "[INFO] [launch]: exit code 0: every process was restarted or ended as expected" in out
    assert done.returncode == 0


def test_a_stop_during_the_first_starts_tells_how_long_they_ran(bench: Bench):
    begun_s = time.monotonic()
    # With a niceness, they are not started yet when the first one interrupts the launcher.
    actions = 'sh("kill -INT $PPID; exec sleep 1000", name="first"),'
    actions += '*[sh("exec sleep 1000", name="late") for _ in range(12)]'
    out = bench.run(actions, "--nice", "late=1").stdout.decode()
    (seconds,) = re.findall(r"13 processes ended as expected after ([\d.]+) s", out)
    assert float(seconds) < time.monotonic() - begun_s


def test_what_was_not_started_has_not_ended_as_expected(control_bench: ControlBench):
    sleeper = 'sh("exec sleep 1000")'
    with control_bench.launch(f"{sleeper}, {sleeper}, {sleeper}", "--stagger", "1000") as run:
        run.wait_for("[sh-1]: process started")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        assert "exit code 0: 1 process ended as expected after " in run.screen
        assert "; 2 processes were not started; ended by: ctrl-c (SIGINT)" in run.screen


def test_the_first_failure_is_repeated_at_the_end_with_its_last_lines(bench: Bench):
    ready = bench.folder / "ready"
    first = f"until [ -e {ready} ]; do sleep 0.02; done; seq 30; exit 7"
    second = f"trap 'exit 5' INT; sleep 1000 & : > {ready}; wait"
    done = bench.run(f'sh("{first}", on_exit=Shutdown()), sh("{second}")')
    out = done.stdout.decode()
    summary = out[out.index("[ERROR] [launch]: first unexpected exit: sh-1 (exit code 7)") :]
    assert summary.splitlines()[1:11] == [f"    {n}" for n in range(21, 31)]
    head, first, second, last = summary.splitlines()[12:]
    assert head.split() == ["PROCESS", "ENDED", "RESTARTS", "RUN", "TIME", "PEAK", "USS"]
    assert first.startswith("    sh-1     exit code 7 ")
    assert second.startswith("    sh-2     stopped (exit code 5) ")
    assert last == "[ERROR] [launch]: exit code 1: sh-1 ended unexpectedly (exit code 7)" + (
        "; stopped with an unusual exit code: sh-2 (5); ended by: the launch file"
    )
    assert done.returncode == 1


def test_the_end_of_a_run_that_went_well_is_one_line_with_the_reason(bench: Bench):
    stop = 'TimerAction(period=0.1, actions=[Shutdown(reason="seen enough")])'
    done = bench.run(f'sh("exec sleep 1000"), {stop}')
    lines = done.stdout.decode().splitlines()
    assert "[INFO] [launch]: shutdown requested by the launch file: seen enough" in lines
    assert re.fullmatch(
        r"\[INFO\] \[launch\]: exit code 0: 1 process ended as expected after \d+\.\d s"
        "; ended by: seen enough",
        lines[-1],
    )
    assert done.returncode == 0


def test_a_process_that_died_four_times_is_in_the_table_at_the_end(bench: Bench):
    count = bench.folder / "count"
    script = f"""
        echo x >> {count}
        [ $(wc -l < {count}) -gt 4 ] || {{ echo '[ERROR] [1.0] [a]: no port'; exit 3; }}
    """
    done = bench.run(f"sh({script!r}, respawn=True, respawn_max_retries=4)")
    out = done.stdout.decode()
    head, columns, row, last = out.splitlines()[-4:]
    assert head == "[INFO] [launch]: processes of this run:"
    assert re.fullmatch(
        r"    sh-1 +died 4x \(exit code 3\), then exit code 0, restarts used up "
        r" +4 +\d+\.\d s +- +no port",
        row,
    )
    assert last.startswith("[INFO] [launch]: exit code 0: every process was restarted or")
    assert done.returncode == 0
    log = (bench.folder / "log/latest/launch.log").read_text().splitlines()
    assert log[-3:-1] == [columns, row]


def test_a_progress_bar_among_the_last_lines_is_shown_as_it_ended(bench: Bench):
    done = bench.run(r"sh('printf \"\\r10%%\\r90%%\\n\\033[33mno port\\033[0m\\n\"; exit 7')")
    out = done.stdout.decode()
    summary = out[out.index("first unexpected exit: sh-1 (exit code 7)") :]
    assert summary.splitlines()[1:3] == ["    90%", "    no port"]
    assert "\x1b" not in out
    assert "\x1b" not in (bench.folder / "log/latest/launch.log").read_text()


NODE = """
import os, sys, time
try:
    print("ready", flush=True)
    while True:
        time.sleep(0.1)  # a signal just before a sleep does not end it
except KeyboardInterrupt:
    os.write(2, b"Traceback (most recent call last):\\n  File 'x', line 1\\nKeyboardInterrupt\\n")
    sys.exit(1)
"""


def test_the_traceback_of_an_unprepared_node_is_one_line_on_screen_and_whole_in_the_file(
    bench: Bench,
):
    (bench.folder / "node.py").write_text(NODE)
    terminal = bench.terminal(
        f'ExecuteProcess(cmd=[sys.executable, "{bench.folder}/node.py"], output="both")'
    )
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text
    assert "Traceback" not in terminal.text
    assert "(ended by KeyboardInterrupt, which the program does not catch" in terminal.text
    assert "Traceback" in (bench.folder / "log" / "latest" / "launch.log").read_text()


def test_the_events_of_a_run_are_in_its_folder_one_json_object_a_line(bench: Bench):
    bench.run('sh("exit 3", respawn=True, respawn_max_retries=1)')
    run = bench.folder / "log" / "latest"
    events = [json.loads(line) for line in (run / "events.jsonl").read_text().splitlines()]
    events = [e for e in events if e["event"] != "resources"]
    assert [e["event"] for e in events] == [
        "started",
        "ended",
        "started",
        "ended",
        "stopping",
        "finished",
    ]
    assert [e["returncode"] for e in events if e["event"] == "ended"] == [3, 3]
    times = [e["monotonic_s"] for e in events]
    assert times == sorted(times)
    plan = json.loads((run / "plan.json").read_text())
    assert [p["cmd"] for p in plan["processes"]] == [["sh", "-c", "exit 3"]]


@pytest.mark.parametrize("actions", ["", "Shutdown()", 'ExecuteProcess(cmd=["/no/such/program"])'])
def test_a_run_without_any_process_ends_by_itself(bench: Bench, actions: str):
    done = bench.run(actions)
    assert done.returncode == (1 if "Execute" in actions else 0)


@pytest.mark.thorough
@pytest.mark.parametrize("closed", ["<&-", "<&- >&-", "<&- >&- 2>&-", "2>&-"])
def test_closed_standard_files_do_no_harm(bench: Bench, closed: str):
    words = shlex.join(bench.command('sh("echo hello")'))
    done = subprocess.run(
        ["bash", "-c", f"{words} {closed}"],
        env=bench.env,
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0
    assert done.stderr == b""
    assert "[sh-1] hello\n" in (bench.folder / "log/latest/launch.log").read_text()


def test_a_launch_file_knows_the_log_folder_of_its_run(bench: Bench):
    done = bench.run('ExecuteProcess(cmd=["echo", "logs in", LaunchLogDir()], output="screen")')
    run = (bench.folder / "log" / "latest").resolve()
    assert f"[echo-1] logs in {run}\n" in done.stdout.decode()


def test_a_launch_file_finds_its_arguments_in_sys_argv_as_under_ros2_launch(bench: Bench):
    actions = 'ExecuteProcess(cmd=["echo", str(sys.argv[:2]), sys.argv[-1]], output="screen")'
    done = bench.run(f'DeclareLaunchArgument("speed"), {actions}', "speed:=9")
    assert b"[echo-1] ['ros2', 'launch'] speed:=9\n" in done.stdout


def _make_old_runs(root: Path) -> list[str]:
    """Of 22, those with an odd number have failed; which are left after another one."""
    for number in range(22):
        old = root / f"2020-01-01-00-00-00-{number:06d}-host-1"
        old.mkdir(parents=True)
        last = {"wall_s": 1.0, "monotonic_s": 1.0, "event": "finished", "exit_code": number % 2}
        (old / "events.jsonl").write_text(json.dumps(last))
    return [f"{number:06d}" for number in range(22) if number not in (0, 2)]


def test_a_run_that_is_over_at_once_deletes_old_ones(bench: Bench):
    root = bench.folder / "log"
    left = _make_old_runs(root)
    bench.run('sh("exit 0")')
    assert [path.name[20:26] for path in sorted(root.glob("2020*"))] == left


def test_old_runs_are_deleted_but_for_those_that_failed(control_bench: ControlBench):
    root = control_bench.folder / "log"
    left = _make_old_runs(root)
    with control_bench.launch('sh("exec sleep 1000")') as run:
        wait_until(lambda: [p.name[20:26] for p in sorted(root.glob("2020*"))] == left, "two less")
        run.ask("quit")
        assert run.exit_code() == 0
    said, kept = run.screen.splitlines()[:2]
    assert said.startswith(f"[INFO] [launch]: All log files can be found below {root}/")
    assert kept == (
        "[INFO] [launch]: The last 20 runs stay there, and all that failed or have a snapshot"
    )
