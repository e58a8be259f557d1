"""Starts that wait for other processes to be ready, with real processes and without ROS."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from launcher.control import format
from tests.process.conftest import Bench, ControlBench, Workspace
from tests.process.test_startup import LAUNCH_FILE, TELL_AT_THE_END, python
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

# `server` is ready when the file `go` is there; `worker` waits for that.
PAIR = (
    'sh("touch worker_ran; exec sleep 60", name="worker", cwd={cwd!r}),'
    'sh("until test -e go; do sleep 0.02; done; echo server is ready; exec sleep 60", '
    'name="server", cwd={cwd!r}),'
)


def supervise(bench: Bench, text: str) -> None:
    (bench.folder / "bench.supervise.yaml").write_text(text, encoding="utf-8")


def supervise_by(bench: Bench, command: str) -> None:
    """The server is ready when a command succeeds."""
    text = f"server: {{ready_when: {{command: {command}}}}}\nworker: {{after: server}}\n"
    supervise(bench, text)


def pair(bench: Bench) -> str:
    return PAIR.format(cwd=str(bench.folder))


def events(bench: Bench) -> list[dict[str, Any]]:
    file = bench.folder / "log" / "latest" / "events.jsonl"
    if not file.exists():
        return []
    return [json.loads(line) for line in file.read_text().splitlines()]


def moments(bench: Bench) -> list[tuple[str, str]]:
    """(event, label of the process) of what is about starts, in order."""
    kinds = ("waiting", "released", "ready", "started", "ended", "not started", "withdrawn")
    return [
        (event["event"], event["process"].rpartition("-")[0])
        for event in events(bench)
        if event["event"] in kinds and "process" in event
    ]


def waits(run: ControlledRun, name: str) -> bool:
    return bool(run.row(name)["waiting_for"])


def go(bench: Bench) -> None:
    (bench.folder / "go").touch()


# ---- kinds of facts


def test_a_process_starts_when_another_has_printed_a_line(control_bench: ControlBench):
    supervise(control_bench, "server: {ready_when: {log: 'is rea.y$'}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        row = run.row("worker")
        assert (row["state"], row["pid"], row["ready"]) == ("STARTING", None, None)
        assert row["waiting_for"].startswith("server: no line with 'is rea.y$' (")
        assert run.row("server")["ready"] is False
        table = run.ask_text("ps")
        assert "waiting for server: no line with 'is rea.y$' (" in table
        assert "not ready: no line with" in table
        assert not (control_bench.folder / "worker_ran").exists()
        go(control_bench)
        wait_until((control_bench.folder / "worker_ran").exists, "the worker runs")
        assert run.row("server")["ready"] is True
        assert "ready after" in run.ask_text("ps", "server")
        ready = next(e for e in run.ask("events")["events"] if e["event"] == "ready")
        assert ready["ready_s"] == pytest.approx(run.row("server")["ready_s"], abs=0.001)
    assert moments(control_bench)[:5] == [
        ("waiting", "worker"),
        ("started", "server"),
        ("ready", "server"),
        ("released", "worker"),
        ("started", "worker"),
    ]


def test_a_coloured_line_counts_without_its_colours(bench: Bench):
    supervise(bench, "a: {ready_when: {log: '^is ready$'}}\nb: {after: a}\n")
    done = bench.run(
        'sh("sleep 0.2; printf \'\\\\033[32mis ready\\\\033[0m\\\\n\'; sleep 0.2", name="a"),'
        'sh("echo b runs", name="b"),'
    )
    assert b"b runs" in done.stdout
    assert ("ready", "a") in moments(bench)


def test_a_process_starts_when_a_port_is_open(control_bench: ControlBench):
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))  # bound, but nobody listens yet
        port = server.getsockname()[1]
        text = f"server: {{ready_when: {{port: {{address: '{port}', every: 50 ms}}}}}}\n"
        supervise(control_bench, f"{text}worker: {{after: server}}\n")
        with control_bench.launch(pair(control_bench)) as run:
            wait_until(lambda: waits(run, "worker"), "the worker waits")
            wait_until(
                lambda: "connection refused" in str(run.row("worker")["waiting_for"]),
                "it says why",
            )
            server.listen()
            wait_until((control_bench.folder / "worker_ran").exists, "the worker runs")


def test_a_process_starts_when_a_command_succeeds(control_bench: ControlBench):
    command = '{run: test -e go && test -n "$LAUNCHER_TEST_MARK", every: 50 ms}'
    supervise(
        control_bench,
        f"server: {{ready_when: {{command: {command}}}}}\nworker: {{after: server}}\n",
    )
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(
            lambda: "exits with code 1" in str(run.row("worker")["waiting_for"]), "it says why"
        )
        go(control_bench)
        wait_until((control_bench.folder / "worker_ran").exists, "the worker runs")


def test_a_process_starts_when_another_has_done_its_work(bench: Bench):
    supervise(bench, "setup: {ready_when: {exit: 0}}\nb: {after: setup}\n")
    done = bench.run('sh("echo b", name="b"), sh("sleep 0.2; echo done", name="setup"),')
    assert done.returncode == 0
    assert done.stdout.index(b"done") < done.stdout.index(b"[b-1] b")


# ---- timeouts


@pytest.mark.parametrize(
    ("consequence", "code", "runs"),
    [("start", 0, True), ("fail", 1, False), ("stop-run", 1, False)],
)
def test_a_timeout_has_its_consequence(bench: Bench, consequence: str, code: int, runs: bool):
    timeout = f"{{processes: a, timeout: 300 ms, on_timeout: {consequence}}}"
    supervise(bench, f"a: {{ready_when: {{log: never}}}}\nb: {{after: {timeout}}}\n")
    length = "60" if consequence == "stop-run" else "1"
    done = bench.run(f'sh("exec sleep {length}", name="a"), sh("echo b runs", name="b"),')
    assert done.returncode == code, done.stdout + done.stderr
    assert (b"[b-2] b runs" in done.stdout) is runs
    said = done.stdout + done.stderr
    assert b"a: no line with 'never'" in said
    assert b"timed out" not in said
    (released,) = [e for e in events(bench) if e["event"] == "released"]
    assert released["waited_s"] >= 0.3
    assert released["why"] == {"start": "timeout"}.get(consequence, consequence)


@pytest.mark.parametrize("code", [0, 3])
def test_one_that_ends_before_it_is_ready_is_not_waited_for(bench: Bench, code: int):
    supervise(bench, "a: {ready_when: {log: never}}\nb: {after: a}\n")
    done = bench.run(f'sh("exit {code}", name="a"), sh("echo b runs", name="b"),')
    assert b"[b-2] b runs" in done.stdout
    said = (done.stdout + done.stderr).decode()
    assert "started although not ready after " in said
    assert f" s: a: it has ended (exit code {code})" in said


def test_one_that_a_condition_keeps_away_is_not_waited_for(bench: Bench):
    supervise(bench, "b: {after: a}\n")
    condition = 'condition=__import__("launch.conditions").conditions.IfCondition("false")'
    done = bench.run(f'sh("true", name="a", {condition}), sh("echo b runs", name="b"),')
    assert b"[b-1] b runs" in done.stdout
    assert done.returncode == 0


def test_a_name_that_no_process_has_is_told_with_its_line(bench: Bench):
    supervise(bench, "b:\n  after: {processes: servr, timeout: 0.5 s}\n")
    done = bench.run('sh("sleep 1", name="server"), sh("echo b runs", name="b"),')
    said = (done.stdout + done.stderr).decode()
    assert (
        "bench.supervise.yaml:2: 'servr' matches no process so far (did you mean 'server'" in said
    )
    assert "servr: it has not been started" in said


def test_one_that_starts_later_is_waited_for(bench: Bench):
    supervise(bench, "b: {after: late}\n")
    late = 'TimerAction(period=0.3, actions=[sh("echo late runs", name="late")])'
    done = bench.run(f'sh("echo b runs", name="b"), {late},')
    assert done.stdout.index(b"late runs") < done.stdout.index(b"b runs")


# ---- what users and the end of the run do


def test_a_user_stops_and_starts_a_process_that_waits(control_bench: ControlBench):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        done = run.shell("stop", "worker")
        assert "stopped before it had started" in done.stdout
        assert run.row("worker")["state"] == "STOPPED"
        assert run.row("worker")["waiting_for"] is None
        assert "started with pid" in run.shell("start", "worker").stdout
        wait_until((control_bench.folder / "worker_ran").exists, "the worker runs")
        assert run.row("server")["ready"] is False


@pytest.mark.parametrize("verb", ["start", "restart"])
def test_a_start_or_restart_of_a_process_that_waits_starts_it_now(
    control_bench: ControlBench, verb: str
):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        done = run.shell(verb, "worker")
        assert "started with pid" in done.stdout, done.stderr
        assert run.row("worker")["state"] == "RUNNING"
        (released,) = [e for e in run.ask("events")["events"] if e["event"] == "released"]
        assert released["why"] == "requested"


def test_kill_without_a_signal_stops_a_process_that_waits(control_bench: ControlBench):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        assert run.shell("kill", "worker").returncode == 0
        assert run.row("worker")["state"] == "STOPPED"


def test_ctrl_c_ends_a_run_in_which_processes_wait(control_bench: ControlBench):
    command = "{run: sleep 30, every: 1 s}"
    supervise(
        control_bench,
        f"server: {{ready_when: {{command: {command}}}}}\nworker: {{after: server}}\n",
    )
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
    wait_until(lambda: not control_bench.survivors(), "nothing is left")
    assert ("withdrawn", "worker") in moments(control_bench)


def test_a_killed_launcher_leaves_nothing_of_what_waits_or_tries(control_bench: ControlBench):
    command = "{run: sleep 300, every: 1 s}"
    supervise(
        control_bench,
        f"server: {{ready_when: {{command: {command}}}}}\nworker: {{after: server}}\n",
    )
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        wait_until(
            lambda: any("sleep 300" in line for line in control_bench.survivors()),
            "the command runs",
        )
        run.process.kill()
        run.process.wait()
        wait_until(lambda: not control_bench.survivors(), "nothing is left")
    assert not (control_bench.folder / "worker_ran").exists()


def test_the_console_says_what_a_process_waits_for(bench: Bench):
    supervise(bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with bench.screen_terminal(pair(bench), columns=140) as terminal:
        terminal.wait_for("worker waiting for server: no line with 'is ready' (")
        go(bench)
        terminal.wait_for("server is ready")
        wait_until((bench.folder / "worker_ran").exists, "the worker runs")


# ---- restarts


def test_a_restarted_process_is_ready_again_and_others_restart_with_it(
    control_bench: ControlBench,
):
    supervise(
        control_bench,
        "server: {ready_when: {log: is ready}, restart: always}\n"
        "worker: {after: server, restart_with: server}\n",
    )
    go(control_bench)
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: run.row("worker")["pid"] is not None, "the worker runs")
        before = run.row("worker")["pid"]
        os.killpg(run.row("server")["pid"], signal.SIGKILL)
        wait_until(lambda: run.row("worker")["pid"] not in (None, before), "it is restarted")
        run.wait_for("restarted, since server-2 has been restarted")
        started = ("started", "worker")
        wait_until(lambda: moments(control_bench).count(started) == 2, "it is noted")
    found = moments(control_bench)
    assert found.count(("ready", "server")) == 2
    again = len(found) - 1 - found[::-1].index(("ready", "server"))
    assert ("waiting", "worker") not in found[again:]  # only the first start waits
    assert ("ended", "worker") in found[again:]


def test_a_restart_with_another_is_not_reported_to_the_launch_file(control_bench: ControlBench):
    supervise(control_bench, "follower: {restart_with: lead}\n")
    actions = (
        'sh("exec sleep 60", name="lead"),sh("exec sleep 60", name="follower", on_exit=Shutdown()),'
    )
    with control_bench.launch(actions) as run:
        wait_until(lambda: run.row("follower")["pid"], "the follower runs")
        before = run.row("follower")["pid"]
        assert run.shell("restart", "lead").returncode == 0
        wait_until(lambda: run.row("follower")["pid"] not in (None, before), "it is restarted")
        os.killpg(run.row("follower")["pid"], signal.SIGKILL)
        assert run.exit_code() == 1  # now it has exited by itself


def test_a_launch_file_that_is_reloaded_may_add_processes_that_wait(control_bench: ControlBench):
    rules = "server: {ready_when: {log: is ready}}\nworker: {after: server}\n"
    supervise(control_bench, f"{rules}late: {{after: server}}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        control_bench.command(f'{pair(control_bench)} sh("exec sleep 60", name="late"),')
        done = run.shell("reload")
        assert done.returncode == 0, done.stderr
        wait_until(lambda: waits(run, "late"), f"the new one waits:\n{run.screen}")
        go(control_bench)
        wait_until(lambda: run.row("late")["pid"], "the new one runs")


def test_a_reload_lets_what_waits_wait_as_it_is_now(control_bench: ControlBench):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        changed = pair(control_bench).replace("touch worker_ran", "touch new_worker_ran")
        control_bench.command(changed)
        done = run.shell("reload")
        assert done.returncode == 0, done.stderr
        row = run.row("worker")
        assert (row["state"], row["pid"]) == ("STARTING", None)
        go(control_bench)
        wait_until((control_bench.folder / "new_worker_ran").exists, "the worker runs as changed")
    assert not (control_bench.folder / "worker_ran").exists()


def test_a_reload_ends_the_wait_for_what_is_gone(control_bench: ControlBench):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        worker, _, _ = pair(control_bench).partition('sh("until')
        control_bench.command(worker)
        done = run.shell("reload")
        assert done.returncode == 0, done.stderr
        wait_until((control_bench.folder / "worker_ran").exists, "the worker runs")


# ---- with other options


def test_paced_starts_wait_for_others_first(bench: Bench):
    supervise(bench, "a: {ready_when: {log: up}}\n'b*': {after: a}\n")
    actions = (
        'sh("echo b1", name="b1"), sh("echo b2", name="b2"), sh("echo up; sleep 1", name="a"),'
    )
    done = bench.run(actions, "--stagger", "0.1")
    assert done.returncode == 0
    started = {e["process"]: e["monotonic_s"] for e in events(bench) if e["event"] == "started"}
    assert started["a-3"] < started["b1-1"]
    assert started["b2-2"] - started["b1-1"] >= 0.1


def test_no_supervise_ignores_the_file_and_supervise_names_another(bench: Bench):
    supervise(bench, "[broken")
    actions = 'sh("echo b", name="b"), sh("sleep 0.2; echo a", name="a"),'
    assert bench.run(actions, "--no-supervise").returncode == 0
    assert bench.run(actions).returncode == 2
    other = bench.folder / "other.yaml"
    other.write_text("b: {after: a}\na: {ready_when: {log: '^a$'}}\n")
    done = bench.run(actions, "--supervise", str(other))
    assert done.stdout.index(b"[a-2] a") < done.stdout.index(b"[b-1] b")


def test_circles_among_the_processes_are_refused_before_anything_starts(bench: Bench):
    supervise(bench, "'*_a': {after: 'x_*'}\n'x_?': {after: '*_a'}\n")
    done = bench.run('sh("touch ran", name="x_1"), sh("true", name="y_a"),')
    assert done.returncode == 2
    text = done.stderr.decode()
    assert "bench.supervise.yaml:2: circle: x_1-1 waits for y_a-2, which waits for x_1-1" in text
    assert not (bench.folder / "log").exists() or not events(bench)


# ---- the plan


def planned(workspace: Workspace, text: str) -> Path:
    (workspace.folder / "a.supervise.yaml").write_text(text, encoding="utf-8")
    return workspace.write(
        """
        ExecuteProcess(cmd=["true"], name="server"),
        ExecuteProcess(cmd=["true"], name="worker"),
        ExecuteProcess(cmd=["true"], name="extra", condition=IfCondition("false")),
        """
    )


def test_a_plan_shows_what_waits_for_what_and_what_is_ready_when(workspace: Workspace):
    file = planned(
        workspace,
        "server: {ready_when: {port: 80, log: up}}\n"
        "worker: {after: {processes: [server, extra], timeout: 5}, restart_with: server}\n",
    )
    done = workspace.call("plan", file)
    assert done.returncode == 0, done.stderr
    assert "ready with: TCP port 127.0.0.1:80, line with 'up'" in done.stdout
    shown = "starts when ready: server-2, extra (switched off, not waited for)"
    assert f"{shown}; at most 5 s, then start" in done.stdout
    assert "restarted with: server-2" in done.stdout
    assert "matches no process" not in done.stdout
    _, server, worker = workspace.document(file)["processes"]
    assert server["ready_when"] == [
        {"kind": "port", "subject": "127.0.0.1:80", "node": None},
        {"kind": "log", "subject": "up", "node": None},
    ]
    assert (server["after"], server["restart_with"]) == (None, [])
    assert worker["after"] == {
        "names": ["server", "extra"],
        "processes": [1],
        "timeout": 5.0,
        "on_timeout": "start",
    }
    assert worker["restart_with"] == [1]
    assert not workspace.started.exists()


def test_a_plan_without_a_file_says_nothing_of_it(workspace: Workspace):
    file = planned(workspace, "server: {ready_when: {port: 80}}\n")
    with_file = workspace.document(file)["processes"][1].keys()
    without = workspace.document(file, "--no-supervise")["processes"][1].keys()
    assert with_file - without == {"ready_when", "after", "restart_with"}


def test_a_plan_tells_the_mistakes_of_the_file(workspace: Workspace):
    done = workspace.call("plan", planned(workspace, "server: {afte: worker}\n"))
    assert done.returncode == 2
    assert "a.supervise.yaml:1: unknown key 'afte' of 'server'" in done.stderr
    file = planned(workspace, "'serv*': {after: 'work*'}\n'worke?': {after: 'serv*'}\n")
    done = workspace.call("plan", file)
    assert done.returncode == 2
    assert "circle: server-2 waits for worker-3, which waits for server-2" in done.stderr


def test_the_schema_is_printed(workspace: Workspace):
    done = workspace.call("plan", "--supervise-schema")
    assert json.loads(done.stdout)["title"] == "Supervision of the processes of a launch file"


# ---- analyze and smoke


def test_analyze_shows_the_chain_of_a_run_that_goes_on_and_of_one_that_is_over(
    control_bench: ControlBench,
):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        found = json.loads(run.shell("analyze", str(run.process.pid), "--json").stdout)
        assert found["is_ready"] is False
        assert "not ready: worker-1 (waiting since" in run.shell("analyze").stdout
        go(control_bench)
        wait_until((control_bench.folder / "worker_ran").exists, "the worker runs")
        run.process.send_signal(signal.SIGINT)
        run.exit_code()
        text = run.shell("analyze").stdout
    assert text.startswith("2 of 2 processes ready after ")
    chain = text[text.index("critical chain") :].splitlines()
    assert chain[1].startswith("worker-1 @")
    assert chain[2].startswith("`-server-2 @")
    latest = str(control_bench.folder / "log" / "latest")
    found = json.loads(run.shell("analyze", latest, "--json").stdout)
    assert found["critical_chain"] == ["worker-1", "server-2"]
    server, worker = sorted(found["processes"], key=lambda one: one["name"])
    assert 0 < server["started_s"] < server["ready_s"] <= worker["released_s"]
    assert worker["released_s"] <= worker["started_s"]


def test_analyze_of_nothing_is_refused(bench: Bench):
    command = [sys.executable, "-m", "launcher", "analyze"]
    done = subprocess.run(command, env=bench.env, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "there is no run in" in done.stderr


def smoke(bench: Bench, expect: str, *words: str) -> subprocess.CompletedProcess[str]:
    (bench.folder / "bench.expect.yaml").write_text(expect, encoding="utf-8")
    *_, file = bench.command(pair(bench))
    return subprocess.run(
        [sys.executable, "-m", "launcher", "smoke", file, *words],
        env=bench.env,
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_smoke_waits_until_all_are_ready_and_expects_it(bench: Bench):
    supervise(bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    go(bench)
    done = smoke(bench, "expect:\n  - ready: server\n    within: 60 s\n", "--for", "0.5")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "smoke: 2 of 2 expectations met" in done.stdout


def test_smoke_is_not_ready_while_a_process_waits(bench: Bench):
    supervise(bench, "server: {ready_when: {log: never}}\nworker: {after: server}\n")
    done = smoke(bench, "expect: []\n", "--ready-within", "3", "--for", "0.5")
    assert done.returncode == 124, done.stdout + done.stderr
    assert "not ready: server-2, worker-1" in done.stdout + done.stderr or (
        "not ready: worker-1, server-2" in done.stdout + done.stderr
    )


# ---- without a file


def test_a_run_without_a_file_imports_nothing_for_it(tmp_path: Path):
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE.replace('["/bin/true"]', '["sleep", "0.2"]'), encoding="utf-8")
    modules = python(TELL_AT_THE_END, str(file)).split()
    ours = (
        "launcher.engine.ready",
        "launcher.model.supervision",
        "launcher.commands.launch.supervise",
        "launcher.engine.helpers.graph_facts",
        "launcher.document",
    )
    assert [name for name in modules if name.startswith(ours)] == []


def test_looking_for_the_file_is_one_system_call(tmp_path: Path):
    file = tmp_path / "one.launch.py"
    file.write_text(LAUNCH_FILE, encoding="utf-8")
    code = (
        "import os, runpy, sys\n"
        "stat, seen = os.stat, []\n"
        "os.stat = lambda path, *a, **k: (seen.append(str(path)), stat(path, *a, **k))[1]\n"
        "sys.argv = ['launcher', sys.argv[1], '--no-log-files']\n"
        "try:\n"
        "    runpy.run_module('launcher', run_name='__main__', alter_sys=True)\n"
        "finally:\n"
        "    print(sum(path.endswith('.supervise.yaml') for path in seen), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(file)], capture_output=True, text=True, timeout=60
    )
    assert done.stderr.splitlines()[-1] == "1"


def test_rows_of_a_run_without_a_file_do_not_mention_it(run: ControlledRun):
    assert "ready" not in run.row("cat")
    assert format.readiness(run.row("cat")) == ""
