"""Starts that wait for other processes to be ready, with real processes and without ROS."""

from __future__ import annotations

import signal
import socket

import pytest

from tests.support.benches import Bench, ControlBench
from tests.support.supervising import events, go, moments, pair, supervise, waits
from tests.support.waiting import wait_until

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
    # It ends when the wait is over; if the run is to be stopped, not by itself.
    wait = f"until grep -qs released {bench.folder}/log/latest/events.jsonl; do sleep 0.05; done"
    ends = "exec sleep 60" if consequence == "stop-run" else wait
    done = bench.run(f'sh("{ends}", name="a"), sh("echo b runs", name="b"),')
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
    mark = bench.folder / "b_ran"
    server = f'sh("until test -e {mark}; do sleep 0.05; done", name="server")'
    done = bench.run(f'{server}, sh("touch {mark}", name="b"),')
    said = (done.stdout + done.stderr).decode()
    assert (
        "bench.supervise.yaml:2: 'servr' matches no process so far (did you mean 'server'" in said
    )
    assert "servr: it has not been started" in said


def test_one_that_starts_later_is_waited_for(bench: Bench):
    supervise(bench, "b: {after: late}\n")
    late = 'TimerAction(period=0.3, actions=[sh("echo late runs", name="late")])'
    done = bench.run(f'sh("echo b runs", name="b"), {late},')
    assert b"b runs" in done.stdout
    found = moments(bench)
    assert found.index(("started", "late")) < found.index(("started", "b"))


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


def test_kill_of_a_process_that_waits_names_what_keeps_it_from_starting(
    control_bench: ControlBench,
):
    supervise(control_bench, "server: {ready_when: {log: is ready}}\nworker: {after: server}\n")
    with control_bench.launch(pair(control_bench)) as run:
        wait_until(lambda: waits(run, "worker"), "the worker waits")
        done = run.shell("kill", "worker")
        assert done.returncode == 1
        assert "(STARTING): `stop` keeps it from being started" in done.stderr


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
