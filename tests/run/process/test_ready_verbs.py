"""What `plan`, `analyze` and `smoke` say of processes that wait, and runs without such."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.control import answer_lines
from tests.launch.process.test_startup import LAUNCH_FILE
from tests.support.benches import Bench, ControlBench, Workspace
from tests.support.controlled_run import ControlledRun
from tests.support.loaded_modules import loaded_by_run
from tests.support.supervising import go, pair, supervise, waits
from tests.support.waiting import wait_until

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


@pytest.mark.thorough
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
    modules = loaded_by_run(file)
    ours = (
        "launcher.run.ready",
        "launcher.base.model.supervision",
        "launcher.launch.supervise",
        "launcher.run.helpers.graph_facts",
        "launcher.base.document",
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
    assert answer_lines.readiness(run.row("cat")) == ""
