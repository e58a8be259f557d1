"""Links to other hosts that are lost, and the end of a run with them."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.control.client import RefusedError
from tests.support.benches import bench_with_sockets
from tests.support.controlled_run import state_of
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


# ---- the link


def test_a_lost_link_is_a_state_and_is_caught_up(bench: HostsBench):
    counted_there = bench.folder / "counted"
    counter = COUNTER.replace("sleep", f"echo >> {counted_there}; sleep")
    actions = f"{counter}, {SLEEPER.format('bot1_a')}, {SLEEPER.format('here')}"
    with bench.launch(actions) as run:
        run.wait_for("count 3")
        wait_until(lambda: is_running(run, "bot1_a"), "the process")
        pid = run.row("bot1_a")["pid"]
        bench.switch("cut bot1")
        wait_until(lambda: run.row("bot1_a")["unreachable_s"] is not None, "a lost link")
        row = run.row("bot1_a")
        assert (row["state"], row["pid"]) == ("RUNNING", pid)
        assert "bot1 is unreachable: cut by the test; its processes run on" in run.screen
        assert "RUNNING, unreachable" in run.ask_text("ps", "bot1_a")
        assert "RUNNING, unreachable" in run.ask_text("info", "bot1_a")
        assert run.row("here")["unreachable_s"] is None
        os.kill(pid, signal.SIGSEGV)
        seen = run.screen.count("count")
        wait_until(lambda: not state_of(pid), "its host has noticed its death")
        noticed_s, size = run.row("bot1_a")["unreachable_s"], counted_there.stat().st_size
        wait_until(lambda: run.row("bot1_a")["unreachable_s"] > noticed_s + 1, "a while")
        wait_until(lambda: counted_there.stat().st_size > size + 10, "lines are written there")
        assert run.screen.count("count") == seen
        bench.switch("restore bot1")
        run.wait_for("bot1 is reachable again after")
        assert "caught up with 1 event and" in run.screen
        assert run.row("bot1_a")["last_exit"]["text"].startswith("SIGSEGV")
        assert run.row("bot1_a")["unreachable_s"] is None
        counted = [int(line.split()[-1]) for line in run.screen.splitlines() if "] count" in line]
        assert counted == list(range(1, len(counted) + 1))
        links = [(e["host"], e["state"]) for e in events(run) if e["event"] == "link"]
        assert links == [("bot1", "ready"), ("bot1", "unreachable"), ("bot1", "ready")]
        ended = next(e for e in events(run) if e["event"] == "ended")
        back = [e for e in events(run) if e["event"] == "link"][-1]
        assert ended["wall_s"] < back["wall_s"] - 0.5  # its own time, not that of the return
        lines = [line.split() for line in run.log.splitlines() if "] count" in line]
        meanwhile = [line for line in lines if ended["wall_s"] < float(line[0]) < back["wall_s"]]
        assert len(meanwhile) > 5


def test_requests_for_unreachable_processes_are_answered(bench: HostsBench):
    with bench.launch(f"{SLEEPER.format('bot1_a')}, {SLEEPER.format('here')}") as run:
        wait_until(lambda: is_running(run, "bot1_a"), "the process")
        bench.switch("cut bot1")
        wait_until(lambda: run.row("bot1_a")["unreachable_s"] is not None, "a lost link")
        for verb, more in (
            ("start", {}),
            ("restart", {}),
            ("pause", {}),
            ("send", {"text": "x"}),
            ("kill", {"signal": "SIGUSR1"}),
        ):
            with pytest.raises(RefusedError, match=r"which is unreachable .*: nothing was done"):
                run.ask(verb, "bot1_a", **more)
        assert "it will be stopped when bot1 can be reached" in run.ask_text("stop", "bot1_a")
        assert is_running(run, "bot1_a")
        bench.switch("restore bot1")
        wait_until(lambda: run.row("bot1_a")["state"] == "STOPPED", "the stop")


def test_a_request_whose_link_is_lost_is_answered(bench: HostsBench):
    stubborn = """sh("trap '' INT; echo ready; while :; do sleep 0.1; done", name="bot1_a",
                     sigterm_timeout="600")"""
    with bench.launch(stubborn) as run:
        run.wait_for("[bot1_a-1] ready")
        stop = run.shell_start("stop", "bot1_a")
        run.wait_for("sending signal 'SIGINT'")
        bench.switch("cut bot1")
        out, err = stop.communicate(timeout=60)
        assert stop.returncode == 1
        assert "bot1, which has become unreachable" in out + err
        bench.switch("restore bot1")
        wait_until(lambda: run.row("bot1_a")["unreachable_s"] is None, "the link")
        assert run.row("bot1_a")["state"] == "STOPPING"
        run.ask("kill", "bot1_a", signal="SIGKILL")


def test_a_host_that_is_gone_takes_its_processes_along(bench: HostsBench):
    handler = """RegisterEventHandler(OnProcessExit(
        on_exit=lambda event, context: LogInfo(msg=f"{event.process_name} {event.returncode}")))"""
    again = 'sh("exec sleep 1000", name="bot1_again", respawn=True)'
    with bench.launch(f"{handler}, {FLEET}, {again}") as run:
        wait_for_fleet(run)
        wait_until(lambda: is_running(run, "bot1_again"), "a process that it would restart")
        bench.switch("power_off bot1")
        run.wait_for("bot1_again-4 -9")
        assert "bot1 is lost: it was restarted" in run.screen
        assert run.row("bot1_a")["last_exit"]["text"] == "lost with bot1"
        assert run.row("bot1_again")["state"] == "EXITED"
        for verb in ("start", "restart"):
            text = "bot1_a-1 cannot be started: bot1 cannot be used any more in this run"
            with pytest.raises(RefusedError, match=text):
                run.ask(verb, "bot1_a")
        assert run.row("bot1_a")["state"] == "EXITED"
        assert is_running(run, "bot2_b")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 1
        assert "bot1 was lost" in run.screen


@pytest.mark.parametrize("option", [["--required", "bot1_a"], ["--exit-when-any-dies"]])
def test_a_process_that_is_lost_can_end_the_run(bench: HostsBench, option: list[str]):
    with bench.launch(FLEET, *option) as run:
        wait_for_fleet(run)
        bench.switch("power_off bot1")
        assert run.exit_code() == 1
        assert "bot1_a-1 ended unexpectedly (lost with bot1)" in run.screen


# ---- the end


@pytest.mark.parametrize(("switch", "code"), [("leave", 0), ("leave_deaf", 1)])
def test_leftovers_are_told_with_their_host(bench: HostsBench, switch: str, code: int):
    with bench.launch(FLEET) as run:
        wait_for_fleet(run)
        bench.switch(f"{switch} bot1")
        bench.switch("cut bot2")  # the switches are thrown in order
        run.wait_for("bot2 is unreachable")
        bench.switch("restore bot2")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == code
        assert "leftover processes on bot1: sleep [7]" in run.screen
        assert ("leftovers on bot1 had to be killed" in run.screen) is bool(code)


def test_an_unreachable_host_is_named_at_the_end(bench: HostsBench):
    with bench.launch(FLEET, "--stop", "*=int:0.2") as run:
        wait_for_fleet(run)
        pid = run.row("bot2_b")["pid"]
        bench.switch("cut bot2")
        run.wait_for("bot2 is unreachable")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 1
        assert "could not be reached: bot2 (bot2_b-2); its processes run on" in run.screen
        assert "exit code 1: could not be reached: bot2 (bot2_b-2)" in run.screen
        assert "bot2 is unreachable, " in run.screen  # while it waits
        assert state_of(pid)


def test_a_second_interrupt_gives_up_an_unreachable_host(bench: HostsBench):
    with bench.launch(FLEET, "--stop", "*=int:600") as run:
        wait_for_fleet(run)
        bench.switch("cut bot2")
        run.wait_for("bot2 is unreachable")
        run.process.send_signal(signal.SIGINT)
        run.wait_for("still waiting for bot2_b-2 (bot2 is unreachable")
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 1
        assert "could not be reached: bot2 (bot2_b-2)" in run.screen


def test_a_host_that_returns_during_the_stop_is_stopped(bench: HostsBench):
    with bench.launch(FLEET) as run:
        wait_for_fleet(run)
        bench.switch("cut bot2")
        run.wait_for("bot2 is unreachable")
        run.process.send_signal(signal.SIGINT)
        run.wait_for("still waiting for bot2_b-2")
        bench.switch("restore bot2")
        assert run.exit_code() == 0


def test_a_host_with_a_leash_stops_its_processes(bench: HostsBench):
    with bench.launch(f"{SLEEPER.format('leashed_a')}, {SLEEPER.format('here')}") as run:
        wait_until(lambda: is_running(run, "leashed_a"), "the process")
        pid = run.row("leashed_a")["pid"]
        bench.switch("cut leashed")
        wait_until(lambda: not state_of(pid), "the stop")
        assert "its processes are stopped there after 1 s (leashed_a-1)" in run.screen
        bench.switch("restore leashed")
        wait_until(lambda: run.row("leashed_a")["state"] == "STOPPED", "what was caught up")
        assert run.row("leashed_a")["last_exit"]["asked"]
