"""Options for restarts, budgets and required processes, on real processes."""

from __future__ import annotations

import json

import pytest

from tests.support.benches import Bench
from tests.support.waiting import wait_until


def test_a_restart_policy_from_the_command_line_restarts_until_its_budget_is_used_up(bench: Bench):
    done = bench.run(
        'sh("echo run; exit 3"), sh("echo other; exit 0")',
        "--restart",
        "sh-1=on-failure,max=2,window=60,backoff=0.01..0.1",
    )
    assert done.stdout.count(b"[sh-1] run\n") == 3
    assert done.stdout.count(b"[sh-2] other\n") == 1
    assert b"[sh-1]: restart 1 of 2 in 0.01" in done.stdout
    assert b"process is given up after 2 restarts within 60 s" in done.stdout
    assert done.returncode == 1


def test_a_stop_that_somebody_asks_for_never_restarts(bench: Bench):
    terminal = bench.terminal('sh("echo ready; exec sleep 1000")', "--restart", "*=always")
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert terminal.text.count("process started with pid") == 1


def test_the_run_ends_with_a_required_process(bench: Bench):
    done = bench.run('sh("exit 0"), sh("exec sleep 1000")', "--required", "sh-1")
    assert done.returncode == 0
    assert b"sh-1 is required and has exited: shutting down" in done.stdout
    assert bench.survivors() == []


def test_the_run_ends_with_the_first_failure_if_requested(bench: Bench):
    done = bench.run('sh("exit 0"), sh("exit 9"), sh("exec sleep 1000")', "--exit-when-any-dies")
    assert done.returncode == 1
    assert b"sh-2 died: shutting down" in done.stdout
    assert b"first unexpected exit: sh-2 (exit code 9)" in done.stdout


def test_without_log_files_there_are_none(bench: Bench):
    done = bench.run('sh("echo hello")', "--no-log-files")
    assert done.returncode == 0
    assert not (bench.folder / "log").exists()


def test_a_broken_launch_file_leaves_no_run_folder(bench: Bench):
    done = bench.run('ExecuteProcess(cmd=["true"], condition=3)')
    assert done.returncode == 2
    assert not (bench.folder / "log").exists()


@pytest.mark.thorough
def test_a_process_over_its_budget_is_restarted(bench: Bench):
    run = bench.start(
        'py("import os, time; files = [os.dup(0) for _ in range(200)]; time.sleep(60)")',
        "--budget",
        "python:fds=100,for=0,action=restart",
    )
    assert run.stdout is not None
    seen = b""
    while seen.count(b"process started with pid") < 2 and (line := run.stdout.readline()):
        seen += line
    run.terminate()
    run.communicate(timeout=60)
    assert b"[WARNING] [python-1]: python-1 uses 20" in seen
    assert seen.count(b"process started with pid") == 2


@pytest.mark.thorough
def test_the_run_ends_with_a_process_over_its_budget_and_has_failed(bench: Bench):
    done = bench.run(
        'py("x = bytearray(150_000_000); import time; time.sleep(60)"), sh("exec sleep 1000")',
        "--budget",
        "python:memory=100M,for=0,action=stop-run",
    )
    assert done.returncode == 1
    assert b"python-1 is over its budget: shutting down" in done.stdout


def test_a_budget_that_cannot_be_read_is_refused_before_anything_starts(bench: Bench):
    done = bench.run('sh("echo started")', "--budget", "sh:memroy=3M")
    assert done.returncode == 2
    assert b"memory" in done.stderr
    assert b"started" not in done.stdout


@pytest.mark.thorough
def test_resource_samples_are_in_the_event_log(bench: Bench):
    run = bench.start('sh("exec sleep 1000")')
    journal = bench.folder / "log/latest/events.jsonl"
    wait_until(lambda: journal.exists() and '"resources"' in journal.read_text(), "a sample")
    run.terminate()
    run.communicate(timeout=60)
    lines = journal.read_text().splitlines()
    samples = [json.loads(line) for line in lines if '"resources"' in line]
    assert samples[0]["processes"]["sh-1"]["processes"] == 1
    assert samples[0]["processes"]["sh-1"]["rss_bytes"] > 0


# Runs until it is warned of, and was looked at twice more.
HUNGRY = """
import os, time
def file(name): return open(f"{os.environ['ROS_LOG_DIR']}/{name}").read()
files = [os.dup(0) for _ in range(200)]
while "python-1 uses" not in file("launch.log"): time.sleep(0.05)
samples = file("events.jsonl").count("resources")
while file("events.jsonl").count("resources") < samples + 2: time.sleep(0.05)
print(os.nice(0))
"""


@pytest.mark.thorough
def test_a_budget_from_a_file_warns_once_and_lets_the_process_run(bench: Bench):
    file = bench.folder / "budgets.yaml"
    file.write_text("python:\n  fds: 100\n  for: 0\n  nice: 3\n")
    (bench.folder / "hungry.py").write_text(HUNGRY)
    hungry = f'ExecuteProcess(cmd=[sys.executable, "{bench.folder}/hungry.py"], output="screen")'
    done = bench.run(hungry, "--budgets", str(file))
    assert done.stdout.count(b"[WARNING] [python-1]: python-1 uses 20") == 1
    assert b"[python-1] 3\n" in done.stdout
    assert done.returncode == 0


def test_a_name_without_a_matching_process_is_reported_at_start_and_end(bench: Bench):
    file = bench.folder / "budgets.yaml"
    file.write_text("# mine\nslep:\n  memory: 1M\n  nice: 1\nsl*: {fds: 99}\n")
    words = ["--restart", "slept=always", "--budget", "nosuch:memory=1M", "--nice", "sl*=1"]
    words += ["--budgets", str(file)]
    until_said = 'until grep -q \\"so far\\" $ROS_LOG_DIR/launch.log; do sleep 0.05; done'
    done = bench.run(f'sh("{until_said}", name="sleep")', *words)
    text = done.stderr.decode() + done.stdout.decode()
    assert done.returncode == 0
    for when in ("so far", "of the whole run"):
        meant = "(did you mean 'sleep'?)"
        assert f"--restart 'slept' matches no process {when} {meant}" in text
        assert f"--budget 'nosuch' matches no process {when}" in text
        assert f"{file}:2: 'slep' matches no process {when} {meant}" in text
    assert "--nice" not in text and "'sl*'" not in text
    assert "[launch]: exit code 0: " in text.splitlines()[-1]


def test_a_required_process_that_can_never_start_is_an_immediate_error(bench: Bench):
    done = bench.run('sh("echo started", name="dispatcher")', "--required", "dispacher")
    assert done.returncode == 2
    assert b"--required 'dispacher' matches no process (did you mean 'dispatcher'?)" in done.stderr
    assert b"started" not in done.stdout


def test_a_required_process_may_be_started_later(bench: Bench):
    later = 'TimerAction(period=0.3, actions=[sh("exit 0", name="late")]), sh("exec sleep 1000")'
    done = bench.run(later, "--required", "late")
    assert done.returncode == 0
    assert b"late-2 is required and has exited: shutting down" in done.stdout
    assert b"of the whole run" not in done.stdout


def test_nodes_with_an_invalid_domain_are_not_started(bench: Bench):
    bench.env["ROS_DOMAIN_ID"] = "233"
    node = "__import__('launch_ros.actions').actions.Node(executable='true'{})"
    done = bench.run(f"sh('echo ran'), {node.format('')}")
    said = (
        b"error: ROS_DOMAIN_ID is '233', which is not a valid domain id: no node can start (true-2)"
    )
    assert said + b"\n" in done.stderr
    assert (done.returncode, done.stdout) == (2, b"")
    of_its_own = node.format(", additional_env={'ROS_DOMAIN_ID': '7'}")
    done = bench.run(f"sh('echo ran'), {of_its_own}")
    assert b"[sh-1] ran" in done.stdout
    assert done.returncode == 0


def test_debug_messages_of_the_launch_file_are_shown_with_debug(bench: Bench):
    actions = "LogDebug(msg='some detail'), LogInfo(msg='a fact')"
    for options, is_shown in (((), False), (("-d",), True)):
        done = bench.run(actions, *options)
        logs = [path.read_text() for path in (bench.folder / "log").glob("*/launch.log")]
        assert b"[INFO] [launch.user]: a fact\n" in done.stdout
        assert (b"[DEBUG] [launch.user]: some detail\n" in done.stdout) is is_shown
        assert any("some detail" in log for log in logs) is is_shown


def test_the_log_file_and_the_lines_of_the_launcher_have_the_name_that_is_given(bench: Bench):
    done = bench.run('sh("echo hello"), LogInfo(msg="a fact")', "-f", "nav.log")

    files = sorted(path.name for path in (bench.folder / "log").glob("latest/*.log"))
    text = (bench.folder / "log/latest/nav.log").read_text()
    assert files == ["nav.log", "sh-1.log"]
    for written in (done.stdout.decode(), text):
        assert "[INFO] [nav]: All log files can be found below " in written
        assert "[INFO] [nav]: exit code 0: " in written
        assert "[INFO] [launch.user]: a fact" in written
        assert "[launch]" not in written
    assert "[sh-1] hello" in text


def test_a_log_file_name_with_a_folder_is_refused(bench: Bench):
    done = bench.run('sh("true")', "--log-file-name", "a/b")
    assert done.returncode == 2
    assert b"'a/b' is not the name of a file" in done.stderr
