"""A supervision file that is changed while its run goes on, and read again by `reload`."""

from __future__ import annotations

import os

import pytest

from launcher.control.client import RefusedError
from tests.run.process.test_reload import changes, pids
from tests.support.benches import ControlBench
from tests.support.waiting import wait_until

SERVER = "sh(\"trap 'exit 3' USR1; echo is ready; while :; do sleep 0.02; done\", name='server')"
WORKER = "sh('exec sleep 1000', name='worker')"
TWO = f"{SERVER}, {WORKER}"


@pytest.fixture
def supervise(control_bench: ControlBench):
    def write(text: str) -> None:
        (control_bench.folder / "bench.supervise.yaml").write_text(text, encoding="utf-8")

    return write


def test_policies_and_rules_apply_to_running_processes(control_bench: ControlBench, supervise):
    with control_bench.launch(TWO) as run:
        run.wait_for("is ready")
        before = pids(run)
        supervise(
            "server: {restart: always, ready_when: {log: is ready}}\n"
            "worker: {restart_with: server, memory: 1G, nice: 5}\n"
        )
        expected = {"server-1": "changed", "worker-2": "changed"}
        assert changes(run, dry_run=True) == expected
        (server, worker) = run.ask("reload")["processes"]
        assert server["details"] == ["restart policy", "ready_when"]
        assert worker["details"] == ["limits", "restart_with", "budget"]
        assert run.row("server")["pid"] == before["server-1"]
        worker_pid = run.row("worker")["pid"]
        assert worker_pid != before["worker-2"]
        assert os.getpriority(os.PRIO_PROCESS, worker_pid) == 5
        assert run.row("server")["ready"] is False  # its line was written before

        os.kill(int(before["server-1"] or 0), 10)
        wait_until(lambda: run.row("server")["ready"], "the restarted server is ready")
        wait_until(lambda: run.row("worker")["pid"] not in (None, worker_pid), "restarted with it")
        assert changes(run) == {"server-1": "same", "worker-2": "same"}

        supervise("{}")
        assert changes(run)["server-1"] == "changed"
        assert run.row("server")["ready"] is None


def test_rules_that_were_removed_can_come_back(control_bench: ControlBench, supervise):
    rules = "server: {ready_when: {log: is ready}}\nworker: {after: server}\n"
    supervise(rules)
    with control_bench.launch(TWO) as run:
        wait_until(lambda: run.row("worker")["state"] == "RUNNING", "the worker, which has waited")
        before = pids(run)
        for text, ready in (("{}", None), (rules, True), ("{}", None), (rules, True)):
            supervise(text)
            run.ask("reload")
            assert run.row("server")["ready"] is ready
        assert pids(run) == before
        run.ask("restart", "server")
        wait_until(lambda: run.row("server")["ready"], "the restarted server is ready")


def test_new_processes_wait_for_those_from_before_there_were_rules(
    control_bench: ControlBench, supervise
):
    setup, failed = "sh('true', name='setup')", "sh('exit 1', name='failed')"
    with control_bench.launch(f"{setup}, {failed}, {WORKER}") as run:
        wait_until(lambda: run.row("failed")["state"] == "EXITED", "its end")
        wait_until(lambda: run.row("setup")["state"] == "EXITED", "its end")
        late = "sh('exec sleep 1000', name='{}')"
        control_bench.command(
            ", ".join([setup, failed, WORKER, late.format("x"), late.format("y")])
        )
        supervise("x: {after: [setup, worker]}\ny: {after: {processes: failed, timeout: 50 min}}\n")
        run.ask("reload")
        wait_until(lambda: run.row("x")["state"] == "RUNNING", "x is released")
        run.wait_for("started although not ready")
        assert "failed: it has ended (exit code 1)" in run.screen


def test_a_process_that_waits_follows_the_new_file(control_bench: ControlBench, supervise):
    supervise("server: {ready_when: {log: never}}\nworker: {after: server}\n")
    with control_bench.launch(TWO) as run:
        wait_until(lambda: "waiting for server" in run.ask_text("ps"), "the worker waits")
        supervise("server: {ready_when: {log: never}}\n")
        assert changes(run) == {"server-1": "same", "worker-2": "changed"}
        wait_until(lambda: run.row("worker")["state"] == "RUNNING", "the worker is released")


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ("worker: {restrat: always}", "bench.supervise.yaml:1: unknown key 'restrat'"),
        (
            "worker: {after: server}\nserver: {after: worker}",
            "circle: worker waits for server, which waits for worker",
        ),
    ],
)
def test_a_mistake_in_it_changes_nothing(control_bench: ControlBench, supervise, wrong, says):
    with control_bench.launch(TWO) as run:
        before = pids(run)
        supervise(wrong)
        with pytest.raises(RefusedError, match=f"(?s){says}"):
            run.ask("reload")
        assert pids(run) == before


def test_watch_reads_it_when_it_appears_and_changes(control_bench: ControlBench, supervise):
    with control_bench.launch(TWO, "--watch") as run:
        wait_until(lambda: run.ask("watch")["launch_files"], "the files are watched")
        supervise("server: {restart: always}\n")
        run.wait_for("the launch file was reloaded: changed: server-1")
        supervise("server: {restart: alwys}\n")
        run.wait_for("the launch file was not reloaded: everything runs on")
        supervise("server: {restart: never}\nworker: {memory: 1G}\n")
        run.wait_for("the launch file was reloaded: changed: server-1, worker-2")
