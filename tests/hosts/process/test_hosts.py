"""Runs with processes on other hosts, over a link within the launcher's process."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from tests.support.benches import bench_with_sockets
from tests.support.controlled_run import ControlledRun, state_of
from tests.support.loopback.bench import (
    COUNTER,
    FLEET,
    SLEEPER,
    HostsBench,
    events,
    is_running,
    wait_for_fleet,
)
from tests.support.waiting import wait_until


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[HostsBench]:
    with bench_with_sockets(HostsBench, tmp_path) as one:
        yield one


def test_processes_run_where_the_hosts_file_says(bench: HostsBench):
    with bench.launch(FLEET) as run:
        wait_for_fleet(run)
        hosts = {row["name"]: row["host"] for row in run.ask("ps")["processes"]}
        assert hosts == {"bot1_a-1": "bot1", "bot2_b-2": "bot2", "here-3": "local"}
        pid = run.row("bot1_a")["pid"]
        assert f"[bot1_a-1]: process started with pid [{pid}] on bot1" in run.screen
        started = {e["process"]: e.get("host") for e in events(run) if e["event"] == "started"}
        assert started == {"bot1_a-1": "bot1", "bot2_b-2": "bot2", "here-3": None}
        assert run.ask_text("ps").splitlines()[0].split()[:3] == ["NAME", "HOST", "STATE"]
        assert "host       bot1" in run.ask_text("info", "bot1_a")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        assert not state_of(pid)
        assert "exit code 0" in run.screen


def test_a_run_without_a_hosts_file_shows_no_hosts(bench: HostsBench):
    run = bench.launch(SLEEPER.format("here"))
    assert "host" in run.row("here")
    plain = [word for word in run.process.args if word not in ("--hosts", str(bench.hosts))]
    run.__exit__()
    with ControlledRun(
        plain, env=bench.env, runtime=bench.runtime, screen=bench.folder / "plain"
    ) as run:
        assert "host" not in run.row("here")
        run.ask("quit")
        run.exit_code()


def test_output_of_another_host_has_prefix_log_and_handlers(bench: HostsBench):
    handler = """RegisterEventHandler(__import__("launch").event_handlers.OnProcessIO(
        on_stdout=lambda event: LogInfo(msg="heard " + event.text.decode().strip())))"""
    done = bench.run(f'{handler}, sh("echo one; echo two >&2; printf three", name="bot1_a")')
    text = done.stdout.decode()
    for line in ("[bot1_a-1] one", "[bot1_a-1] two", "[bot1_a-1] three", "heard one"):
        assert line in text
    assert done.returncode == 0
    (log,) = (bench.folder / "log").glob("2*/launch.log")
    assert "[bot1_a-1] three" in log.read_text()


def test_nothing_starts_if_hosts_cannot_be_used(bench: HostsBench):
    actions = ",".join(
        f'sh("touch {bench.folder}/{name}", name="{name}")'
        for name in ("here", "bot1_a", "refuses1_b", "missing1_c")
    )
    done = bench.run(actions)
    text = done.stdout.decode()
    assert done.returncode == 1
    assert "refuses1 (127.0.0.1) cannot be used: the host key has changed\\x1b[2J" in text
    assert "missing1 (127.0.0.1) cannot be used: connection timed out" in text
    assert "exit code 1: cannot be used: refuses1, missing1" in text
    assert not any((bench.folder / name).exists() for name in ("here", "bot1_a"))


def test_a_run_goes_on_without_a_host_that_is_skipped(bench: HostsBench):
    actions = f"""{FLEET}, {SLEEPER.format("missing1_c")},
        RegisterEventHandler(__import__("launch").event_handlers.OnProcessStart(
            on_start=lambda event, context: LogInfo(msg="heard of " + event.process_name)))"""
    done = bench.run(actions)
    assert b"to start the others without: --skip-host missing1\n" in done.stdout
    with bench.launch(actions, "--skip-host", "missing*", "--skip-host", "bot2") as run:
        wait_until(lambda: is_running(run, "bot1_a") and is_running(run, "here"), "the others")
        assert {row["name"] for row in run.ask("ps")["processes"]} == {"bot1_a-1", "here-3"}
        run.wait_for("heard of here-3")
        assert "[WARNING] [bot2_b-2]: not started: bot2 is skipped" in run.screen
        assert "[WARNING] [missing1_c-4]: not started: missing1 is skipped" in run.screen
        assert "heard of bot2" not in run.screen
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        assert "2 processes ended as expected" in run.screen


def test_what_is_required_is_not_skipped(bench: HostsBench):
    done = bench.run(FLEET, "--skip-host", "bot2", "--required", "*_b")
    assert done.returncode == 2
    assert b"error: bot2_b-2 is required, and its host, 'bot2', is skipped\nhint: " in done.stderr


def test_a_run_of_which_everything_is_skipped_ends(bench: HostsBench):
    done = bench.run(SLEEPER.format("bot1_a"), "--skip-host", "bot1")
    assert done.returncode == 0
    assert b"not started: bot1 is skipped" in done.stdout


def test_an_interrupt_ends_the_wait_for_hosts(bench: HostsBench):
    actions = f"{SLEEPER.format('silent1_a')}, {SLEEPER.format('here')}"
    with bench.launch(actions) as run:
        run.wait_for("All log files")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 130  # as before the launcher connects
        assert "process started" not in run.screen
        assert "exit code 130: nothing was started; ended by: ctrl-c (SIGINT)" in run.screen


def test_an_error_in_the_hosts_file_is_an_error_of_usage(bench: HostsBench):
    bench.hosts_text = "hosts: {bot1: {address: 127.0.0.1}}\nplace: {x: bot3}\n"
    done = bench.run(SLEEPER.format("x"))
    assert done.returncode == 2
    assert b"bot3" in done.stderr


def test_a_rule_that_matches_nothing_is_an_error_before_anything_starts(bench: HostsBench):
    bench.hosts_text = "hosts: {bot1: {address: 127.0.0.1}}\nplace: {y: bot1}\n"
    done = bench.run('sh("echo started", name="x")')
    assert done.returncode == 2
    assert b"hosts.yaml:2: 'y' matches no process" in done.stderr
    assert b"started" not in done.stdout


def test_what_a_timer_of_a_launch_file_starts_is_placed_with_the_file(bench: HostsBench):
    rules = "place: {include:bench.launch.py: bot1, here: local}"
    bench.hosts_text = f"hosts: {{bot1: {{address: 127.0.0.1}}}}\n{rules}\n"
    timer = 'TimerAction(period=0.01, actions=[sh("exec sleep 1000", name="late")])'
    with bench.launch(f"{timer}, {SLEEPER.format('here')}") as run:
        wait_until(lambda: len(run.ask("ps")["processes"]) == 2, "both processes")
        wait_until(lambda: is_running(run, "late"), "a running process")
        hosts = {row["name"]: row["host"] for row in run.ask("ps")["processes"]}
        assert hosts == {"here-1": "local", "late-2": "bot1"}


LATER = """RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: [
    sh("exit 0", name="{}")] if event.process_name == "here-1" else []))"""


def test_a_host_that_nobody_could_foresee_is_connected_to_when_it_is_needed(bench: HostsBench):
    bench.hosts_text = "hosts: {bot1: {address: 127.0.0.1}}\nplace: {here: local, 'bot1_*': bot1}\n"
    done = bench.run(f'{LATER.format("bot1_late")}, sh("exit 0", name="here")')
    assert b"'bot1_*' matches nothing that can be foreseen" in done.stderr
    assert b"[bot1_late-2]: process started with pid" in done.stdout
    assert b"on bot1\n" in done.stdout
    assert done.returncode == 0


def test_a_later_process_for_which_rules_disagree_is_not_started(bench: HostsBench):
    bots = "{bot1: {address: 127.0.0.1}, bot2: {address: 127.0.0.1}}"
    bench.hosts_text = f"hosts: {bots}\nplace: {{'bot1_*': bot1, '*_x': bot2, here: local}}\n"
    done = bench.run(f'{LATER.format("bot1_x")}, sh("exit 0", name="here")')
    assert b"[ERROR] [bot1_x-2]: not started: two hosts for bot1_x-2: " in done.stdout
    assert b"bot1_x-2 could not be placed" in done.stdout
    assert done.returncode == 1


def test_a_restart_policy_is_the_hosts_and_is_seen(bench: HostsBench):
    actions = 'sh("exit 3", name="bot1_a", respawn=True, respawn_delay=0.05)'
    done = bench.run(actions, "--restart", "bot1_a=on-failure,max=2,backoff=0.05..0.1")
    text = done.stdout.decode()
    assert text.count("process started with pid") == 3
    assert "restart 2 of 2 in 0." in text
    assert "process is given up after 2 restarts" in text
    assert done.returncode == 1


@pytest.mark.parametrize("option", [["--required", "bot1_a"], ["--exit-when-any-dies"]])
def test_a_death_there_can_end_the_run(bench: HostsBench, option: list[str]):
    done = bench.run(f'sh("exit 3", name="bot1_a"), {SLEEPER.format("bot2_b")}', *option)
    assert done.returncode == 1
    assert b"bot1_a-1 ended unexpectedly (exit code 3)" in done.stdout
    assert b"first unexpected exit: bot1_a-1 on bot1 (exit code 3)" in done.stdout
    assert b"bot1_a-1  exit code 3 on bot1 " in done.stdout  # the table


def test_what_follows_an_exit_there_follows(bench: HostsBench):
    handler = """RegisterEventHandler(OnProcessExit(
        on_exit=lambda event, context: LogInfo(msg=f"{event.process_name} {event.returncode}")))"""
    done = bench.run(f'{handler}, sh("exit 4", name="bot1_a")')
    assert b"bot1_a-1 4" in done.stdout


def test_a_program_that_is_missing_there(bench: HostsBench):
    done = bench.run('ExecuteProcess(cmd=["./no-such-program"], name="bot1_a")')
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    line = next(each for each in lines if b"could not be started: No" in each)
    assert b"cmd './no-such-program'; if bot1 lacks it: python -m launcher hosts sync" in line


def test_a_command_is_shown_as_it_is_there(bench: HostsBench):
    with bench.launch('py("import time; time.sleep(1000)", name="bot1_a")') as run:
        wait_until(lambda: is_running(run, "bot1_a"), "a running process")
        info = run.ask_text("info", "bot1_a")
        assert "command    <python> -c import time" in info
        assert "folder     the home on bot1" in info
        (found,) = json.loads(run.shell("runs", "--json").stdout)["runs"]
        unit = run.row("bot1_a")["unit"]
        assert unit.startswith(f"launcher-{found['id'].rpartition('-')[2]}-")
        assert f"unit       {unit}" in info
        assert ".log (on this machine)" in info
        os.kill(run.row("bot1_a")["pid"], signal.SIGKILL)
        run.exit_code()
        assert "cmd '<python> -c import time" in run.screen


def test_a_time_limit_stops_all_hosts(bench: HostsBench):
    done = bench.run(FLEET, "--timeout", "0.5")
    assert done.returncode == 0
    assert done.stdout.count(b"process was stopped") == 3


def test_stops_escalate_there_and_are_reported(bench: HostsBench):
    actions = """sh("trap '' INT TERM; echo ready; while :; do sleep 0.1; done", name="bot1_a",
                    sigterm_timeout="0.1", sigkill_timeout="0.1")"""
    with bench.launch(actions) as run:
        run.wait_for("[bot1_a-1] ready")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 130
        assert "failed to terminate '0.1' seconds after receiving 'SIGINT'" in run.screen
        assert "sending signal 'SIGKILL' to process[bot1_a-1]" in run.screen


def test_starts_are_paced_over_all_hosts(bench: HostsBench):
    done = bench.run(
        ",".join(f'sh("exit 0", name="{name}")' for name in ("here", "bot1_a", "bot2_b")),
        *("--stagger", "0.3"),
    )
    assert done.returncode == 0
    (path,) = (bench.folder / "log").glob("2*/events.jsonl")
    entries = [json.loads(line) for line in path.read_text().splitlines()]
    times = {e["process"]: e["monotonic_s"] for e in entries if e["event"] == "started"}
    # A start there is told to the host in time, and may take the host a while.
    assert times["bot1_a-2"] - times["here-1"] >= 0.3
    assert times["bot2_b-3"] - times["here-1"] >= 0.6


READY = 'sh("sleep 0.3; echo up; exec sleep 60", name="bot1_a"),'


def test_processes_of_other_hosts_wait_and_are_waited_for(bench: HostsBench):
    rules = "bot1_a: {ready_when: {log: '^up$'}}\nbot2_b: {after: bot1_a}\nhere: {after: bot2_b}\n"
    (bench.folder / "bench.supervise.yaml").write_text(rules)
    actions = f"{SLEEPER.format('here')}, {SLEEPER.format('bot2_b')}, {READY}"
    with bench.launch(actions) as run:
        wait_until(lambda: run.row("here")["pid"], "the last one runs")
        order = [e["process"] for e in events(run) if e["event"] == "started"]
        assert order == ["bot1_a-3", "bot2_b-2", "here-1"]
        assert run.row("bot1_a")["ready"] is True
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0


@pytest.mark.parametrize("consequence", ["start", "fail"])
def test_a_wait_of_a_process_of_another_host_ends_by_its_timeout(
    bench: HostsBench, consequence: str
):
    after = f"{{processes: bot1_a, timeout: 0.3, on_timeout: {consequence}}}"
    rules = f"bot1_a: {{ready_when: {{log: never}}}}\nbot2_b: {{after: {after}}}\n"
    (bench.folder / "bench.supervise.yaml").write_text(rules)
    with bench.launch(f"{READY} {SLEEPER.format('bot2_b')}") as run:
        state = {"start": "RUNNING", "fail": "FATAL"}[consequence]
        wait_until(lambda: run.row("bot2_b")["state"] == state, f"it is {state}:\n{run.screen}")
        assert run.row("bot1_a")["ready"] is False


def test_a_process_of_another_host_is_stopped_while_it_waits(bench: HostsBench):
    rules = "bot1_a: {ready_when: {log: never}}\nbot2_b: {after: bot1_a}\n"
    (bench.folder / "bench.supervise.yaml").write_text(rules)
    with bench.launch(f"{READY} {SLEEPER.format('bot2_b')}") as run:
        wait_until(lambda: run.row("bot2_b")["waiting_for"], "it waits")
        run.ask("stop", "bot2_b")
        assert run.row("bot2_b")["state"] == "STOPPED"
        assert "started with pid" in str(run.ask("start", "bot2_b"))
        wait_until(lambda: run.row("bot2_b")["pid"], "it runs")


def test_starts_on_an_unreachable_host_hold_up_no_others(bench: HostsBench):
    actions = f"""{SLEEPER.format("bot1_a")}, RegisterEventHandler(
        __import__("launch").event_handlers.OnProcessIO(
        on_stdout=lambda event: [{SLEEPER.format("bot1_b")}, {SLEEPER.format("here_b")}])),
        sh("exec cat", name="here")"""
    with bench.launch(actions, "--max-starting", "1") as run:
        wait_until(lambda: is_running(run, "bot1_a") and is_running(run, "here"), "the start")
        bench.switch("cut bot1")
        run.wait_for("bot1 is unreachable")
        run.ask("send", "here-2", text="go")
        wait_until(lambda: len(run.ask("ps")["processes"]) == 4, "four processes")
        wait_until(lambda: is_running(run, "here_b"), "a start here")
        assert run.row("bot1_b")["state"] == "STARTING"
        bench.switch("restore bot1")
        wait_until(lambda: is_running(run, "bot1_b"), "a start there")


# ---- requests


def test_verbs_work_on_processes_of_other_hosts(bench: HostsBench):
    with bench.launch(f'sh("exec cat", name="bot1_cat"), {SLEEPER.format("here")}') as run:
        wait_until(lambda: is_running(run, "bot1_cat"), "the process")
        assert run.ask_text("send", "bot1_cat", text="hello").endswith(
            "received 6 bytes on its standard input"
        )
        run.wait_for_log("bot1_cat", "hello")
        pid = run.row("bot1_cat")["pid"]
        assert run.ask_text("pause", "bot1_cat") == "bot1_cat-1 paused with SIGSTOP"
        # It is told when the host has sent the signal; the kernel carries it out a moment later.
        wait_until(lambda: state_of(pid) == psutil.STATUS_STOPPED, "it stands still")
        assert run.row("bot1_cat")["paused"]
        assert run.ask_text("resume", "bot1_cat") == "bot1_cat-1 resumed with SIGCONT"
        assert f"instead of {pid}" in run.ask_text("restart", "bot1_cat")
        assert "stopped in" in run.ask_text("stop", "bot1_cat")
        assert run.row("bot1_cat")["state"] == "STOPPED"
        assert "started with pid" in run.ask_text("start", "bot1_cat")
        answer = run.ask_text("kill", "bot1_cat", signal="SIGTERM")
        assert "ended in" in answer
        assert run.row("bot1_cat")["last_exit"]["asked"]
        run.ask("quit")
        assert run.exit_code() == 0


def test_a_signal_can_count_as_a_crash(bench: HostsBench):
    actions = ",".join(
        f'sh("exec sleep 1000", name="{name}", respawn=True)' for name in ("bot1_a", "here")
    )
    with bench.launch(actions) as run:
        for name in ("bot1_a", "here"):
            wait_until(lambda name=name: is_running(run, name), "the process")
            run.ask("kill", name, signal="SIGKILL", as_crash=True)
            wait_until(lambda name=name: run.row(name)["restarts"] == 1, "a restart")
            assert not run.row(name)["last_exit"]["asked"]
        run.ask("kill", "here", as_crash=True)
        wait_until(lambda: run.row("here")["restarts"] == 2, "another restart")


def test_output_of_other_hosts_can_be_filtered_and_read(bench: HostsBench):
    with bench.launch(COUNTER) as run:
        run.wait_for("count 1")
        run.ask("mute", "bot1_counter")
        wait_until(lambda: run.row("bot1_counter")["hidden_lines"] > 3, "hidden lines")
        lines = [line["text"] for line in run.ask("logs", "bot1_counter")["lines"]]
        assert lines[0] == "count 1"
        run.ask("grep", "bot1_counter", pattern="count 1")
        run.ask("unmute")
        run.wait_for("count 1")
        run.ask("quit")
        assert run.exit_code() == 0


def test_resources_are_those_that_the_host_has_sampled(bench: HostsBench):
    with bench.launch(f"{SLEEPER.format('bot1_a')}, {SLEEPER.format('here')}") as run:
        wait_until(lambda: run.row("bot1_a")["uss_bytes"] == 5_000_000, "a sample")
        assert run.row("bot1_a")["cpu_percent"] == 12.5
        bench.switch("cut bot1")
        wait_until(lambda: run.row("bot1_a")["uss_bytes"] is None, "no sample any more")
        assert run.row("bot1_a")["state"] == "RUNNING"


def test_budgets_judge_the_samples_of_the_host(bench: HostsBench):
    budget = "bot1_a:memory=1M,for=0.1,action=restart"
    with bench.launch(SLEEPER.format("bot1_a"), "--budget", budget) as run:
        run.wait_for("bot1_a-1 uses 4.8 MiB (USS), more than its budget of 1.0 MiB (USS)")
        wait_until(lambda: run.row("bot1_a")["last_exit"] is not None, "its restart")
        assert run.row("bot1_a")["last_exit"]["asked"]
        wait_until(lambda: is_running(run, "bot1_a"), "its next life")


def test_limits_hold_there(bench: HostsBench):
    done = bench.run('sh("ulimit -n", name="bot1_a")', "--limit", "bot1_a:nofile=77")
    assert b"[bot1_a-1] 77" in done.stdout
