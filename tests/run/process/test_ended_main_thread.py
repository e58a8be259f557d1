"""Processes whose main thread has ended while others live: alive, though /proc shows a zombie."""

from __future__ import annotations

import os
import select
import signal
import sys

import pytest

from launcher.posix import proc
from launcher.posix.cleanup import RUN_ID_VARIABLE, sweep
from launcher.posix.cleanup.run_id import run_id_of
from launcher.ros.node_tables import vitals
from launcher.run.stacks.dump import of_kernel
from launcher.smoke.observe.left_behind import processes_of
from tests.support.benches import Bench
from tests.support.ended_main_thread import PROGRAM, started
from tests.support.waiting import wait_until

# Of a launcher that lives: doctors of other tests stop what is left of one that does not.
RUN_ID = f"{os.getpid()}-ended"
ENV = {**os.environ, RUN_ID_VARIABLE: RUN_ID}
DAEMON = f"setsid {sys.executable} {PROGRAM} &"


def test_it_is_alive_with_its_own_command_environment_and_memory():
    with started(ENV) as pid:
        assert proc.stat_fields(pid)[proc.STATE] == b"Z"
        assert proc.is_alive(pid)
        wait_until(lambda: proc.state(pid) == "S", "it sleeps")
        assert proc.describe_state(pid).startswith("state S (sleeping)")
        assert proc.start_ticks(pid) == int(proc.stat_fields(pid)[proc.START_TICKS])
        assert proc.command_line(pid) == [sys.executable, PROGRAM]
        assert run_id_of(pid) == RUN_ID
        assert (proc.uss_bytes(pid) or 0) > 1_000_000
        assert not proc.was_in_exec(pid)
        assert list(proc.family([pid])) == [pid]
        os.kill(pid, signal.SIGSTOP)
        wait_until(lambda: proc.is_suspended(pid), "it is suspended")
        found = vitals(pid)
        assert found is not None
        assert found.status == "stopped"
        assert (found.uss_bytes or 0) > 1_000_000
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda: not proc.is_alive(pid), "it is a zombie with all its threads")
        assert vitals(pid) is None
        assert (proc.state(pid), proc.start_ticks(pid), run_id_of(pid)) == ("Z", None, None)


def test_its_pidfd_reports_the_end_of_the_last_thread():
    with started() as pid:
        pidfd = os.pidfd_open(pid)
        assert select.select([pidfd], [], [], 0.0)[0] == []
        assert os.waitid(os.P_PIDFD, pidfd, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None
        signal.pidfd_send_signal(pidfd, signal.SIGTERM)
        assert select.select([pidfd], [], [], 60.0)[0] == [pidfd]
        end = os.waitid(os.P_PIDFD, pidfd, os.WEXITED | os.WNOWAIT)
        assert end is not None
        assert end.si_status == signal.SIGTERM
        os.close(pidfd)


def test_it_is_found_by_its_run_id():
    with started(ENV) as pid:
        assert pid in sweep.find(RUN_ID)[0]
        assert processes_of(os.getpid())[pid] == f"{sys.executable} {PROGRAM}"


def test_of_its_threads_the_living_ones_are_shown():
    with started() as pid:
        dump = of_kernel(pid, "", "")
        assert PROGRAM in dump.command
        assert len(dump.threads) == 1
        assert dump.threads[0].tid != pid


def test_as_a_process_of_a_run_it_lives_until_it_is_stopped(bench: Bench):
    actions = f'ExecuteProcess(cmd=[sys.executable, "{PROGRAM}"], output="screen")'
    terminal = bench.terminal(actions, "--stop", "*=int:0.1,term:60")
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert "sending signal 'SIGTERM'" in terminal.text
    assert bench.survivors() == []


def test_as_a_daemon_it_is_stopped_with_its_run(bench: Bench):
    terminal = bench.terminal(f'sh("{DAEMON} exec sleep 1000")')
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert "stopping leftover processes: python" in terminal.text
    assert bench.survivors() == []


@pytest.mark.parametrize("group", ["none", ""])
def test_as_a_daemon_it_does_not_outlive_a_killed_launcher(bench: Bench, group: str):
    bench.env["LAUNCHER_CGROUP"] = group
    terminal = bench.terminal(f'sh("{DAEMON} exec sleep 1000")')
    terminal.wait_for("ready")
    assert any(PROGRAM in line for line in bench.survivors())
    terminal.kill()
    wait_until(lambda: bench.survivors() == [], "nothing is left")
