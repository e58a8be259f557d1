"""Restarts and reloads of processes that wait for others to be ready."""

from __future__ import annotations

import os
import signal

from tests.support.benches import ControlBench
from tests.support.supervising import go, moments, pair, supervise, waits
from tests.support.waiting import wait_until


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
