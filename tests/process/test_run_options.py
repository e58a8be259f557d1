"""What the command line says about supervising, on real processes."""

from __future__ import annotations

from tests.process.conftest import Bench


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
    assert b"sh-1 is required and has ended: shutting down" in done.stdout
    assert bench.survivors() == []


def test_the_run_ends_with_the_first_death_if_that_is_wanted(bench: Bench):
    done = bench.run('sh("exit 0"), sh("exit 9"), sh("exec sleep 1000")', "--exit-when-any-dies")
    assert done.returncode == 1
    assert b"sh-2 died: shutting down" in done.stdout
    assert b"first to die unasked: sh-2 (exit code 9)" in done.stdout


def test_the_run_ends_after_its_time(bench: Bench):
    done = bench.run('sh("exec sleep 1000")', "--timeout", "0.3")
    assert done.returncode == 0
    assert b"the time of 0.3 s is over" in done.stdout
    assert bench.survivors() == []


def test_without_log_files_there_are_none(bench: Bench):
    done = bench.run('sh("echo hello")', "--no-log-files")
    assert done.returncode == 0
    assert not (bench.folder / "log").exists()


def test_a_broken_launch_file_leaves_no_run_folder(bench: Bench):
    done = bench.run('ExecuteProcess(cmd=["true"], condition=3)')
    assert done.returncode == 2
    assert not (bench.folder / "log").exists()
