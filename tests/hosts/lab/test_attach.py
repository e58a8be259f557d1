"""Returning to a run on several robots with systemd."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.hosts import Lab, Robot, needs_robots
from tests.support.hosts.remote_run import RemoteRun
from tests.support.json_forms import fit
from tests.support.waiting import wait_until

ROOT = {"user": "root", "engine": "systemd"}
APART = "output={'stdout': 'screen', 'stderr': 'log'}"
LAUNCH_FILE = f"""
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def sh(name, script, **more):
    return ExecuteProcess(cmd=["/bin/sh", "-c", script], name=name, **more)

def generate_launch_description():
    return LaunchDescription([
        sh("many", "seq 20; exec sleep 1000", output="screen"),
        sh("few", "read go; seq 3; exec sleep 1000", respawn=True, {APART}),
        sh("mad", "read go; echo mad; exit 1", output="screen", respawn=True, respawn_delay=900.0),
    ])
"""
LAST = ["[many-1] 19", "[many-1] 20", "[few-2] 1", "[few-2] 2", "[few-2] 3", "[mad-3] mad"]


@pytest.fixture(scope="module")
def robots(lab: Lab) -> list[Robot]:
    needs_robots()
    return [lab.robot(name) for name in ("bot1", "bot2")]


@pytest.fixture
def left(lab: Lab, robots: list[Robot], tmp_path: Path) -> Iterator[Path]:
    """The folder of a run that was left on both robots."""
    hosts = dict.fromkeys(robots, ROOT)
    lab.hosts_file(tmp_path / "hosts.yaml", hosts, {"many": "bot1", "few": "bot2", "mad": "bot2"})
    (tmp_path / "t.launch.py").write_text(LAUNCH_FILE, encoding="utf-8")
    with RemoteRun(lab, tmp_path / "screen", "t.launch.py", "--hosts", "hosts.yaml") as run:
        run.wait_for(r"^\[many-1\] 20$")
        send(lab, "few")
        run.wait_for(r"^\[few-2\] 3$")
        send(lab, "mad")
        run.wait_for("restart 1 in 900 s")
        detached = lab.operator.launcher("detach", "--json")
        assert detached.returncode == 0, detached.stderr
        fit("detach", detached.stdout)
        assert run.wait() == 0
    yield tmp_path
    lab.operator.launcher("attach", "--hosts", tmp_path / "hosts.yaml", "--stop")


def attach(lab: Lab, folder: Path, *words: str) -> RemoteRun:
    screen = folder / f"attached{len(list(folder.glob('attached*')))}"
    return RemoteRun(lab, screen, "attach", "--hosts", "hosts.yaml", *words)


# The second connection gets no answer, or ends at once.
PROXY = """
import os, socket, sys, time
try:
    os.mkdir("met")
except FileExistsError:
    time.sleep(float(sys.argv[1]))
    sys.exit("no way there")
with socket.create_connection((sys.argv[2], sys.argv[3])) as there:
    socket.send_fds(socket.socket(fileno=1), [b"x"], [there.fileno()])
"""


def attach_in_vain(lab: Lab, folder: Path, robots: list[Robot], *, silent_s: float) -> RemoteRun:
    """With a way to bot2 that works only until the run has been found there."""
    (folder / "proxy.py").write_text(PROXY, encoding="utf-8")
    command = f"{sys.executable} proxy.py {silent_s} %h %p"
    ssh = {**lab.ssh_options(), "ProxyUseFdpass": "yes", "ProxyCommand": command}
    known = {robots[0]: ROOT, robots[1]: {**ROOT, "ssh": ssh}}
    lab.hosts_file(folder / "in-vain.yaml", known, {})
    screen = folder / "in-vain"
    return RemoteRun(lab, screen, "attach", "--hosts", "in-vain.yaml")


def runs_on(lab: Lab, folder: Path) -> bool:
    """Whether the run can be attached to, and nothing of it was ended."""
    with attach(lab, folder, "-n", "0") as run:
        run.wait_for("runs on bot. with pid", 2)
        # It is refused until the hosts have got all requests.
        wait_until(lambda: lab.operator.launcher("detach").returncode == 0, "it is detached")
        return run.wait() == 0


def send(lab: Lab, name: str) -> None:
    assert lab.operator.launcher("send", name, "go").returncode == 0


def lines_of_processes(run: RemoteRun) -> list[str]:
    return re.findall(r"^\[[a-z]+-\d\] .*$", run.text, re.MULTILINE)


def test_it_begins_with_the_last_lines_of_the_run(lab: Lab, left: Path):
    for _ in range(3):  # what the launcher itself has written to the journal does not count
        with attach(lab, left, "-n", "6") as run:
            run.wait_for(r"^\[mad-3\] mad$")
            assert lab.operator.launcher("detach").returncode == 0
            assert run.wait() == 0
        assert lines_of_processes(run) == LAST
        assert "unknown process" not in run.text


def test_lines_go_on_after_a_restart(lab: Lab, left: Path):
    with attach(lab, left, "-n", "0") as run:
        run.wait_for("runs on bot. with pid", 2)
        # Its socket comes after the first lines.
        wait_until(lambda: lab.operator.launcher("ps").returncode == 0, "it can be asked")
        assert lab.operator.launcher("restart", "few").returncode == 0
        send(lab, "few")
        run.wait_for(r"^\[few-2\] 3$")
        assert lab.operator.launcher("start", "mad").returncode == 0
        send(lab, "mad")
        run.wait_for(r"^\[mad-3\] mad$")
        assert lines_of_processes(run) == LAST[2:]
        told = lab.operator.launcher("info", "few").stdout
        assert "environment  not known: another launcher started it" in told
        assert lab.operator.launcher("detach").returncode == 0
        assert run.wait() == 0
    with attach(lab, left, "-n", "8") as run:
        run.wait_for(r"^\[mad-3\] mad$", 2)
        assert lines_of_processes(run) == LAST[2:] * 2  # of both lives
        assert "unknown process" not in run.text
        assert run.interrupt() in (0, 130)


def test_a_run_goes_on_if_one_of_its_hosts_refuses(lab: Lab, robots: list[Robot], left: Path):
    with attach_in_vain(lab, left, robots, silent_s=0) as run:
        assert run.wait() == 1
    assert "bot2 (" in run.text
    assert "not attached: the run goes on without this launcher" in run.text
    assert "--skip-host" not in run.text
    assert runs_on(lab, left)


def test_a_run_goes_on_after_ctrl_c_before_its_hosts_answer(
    lab: Lab, robots: list[Robot], left: Path
):
    with attach_in_vain(lab, left, robots, silent_s=60) as run:
        run.wait_for(r"All log files can be found below .*\n")
        events = Path(re.findall("below (.*)", run.text)[0], "events.jsonl")
        wait_until(lambda: '"ready"' in events.read_text(), "bot1 has answered")
        assert run.interrupt() == 130
    assert "exit code 130: not attached" in run.text
    assert "not attached: the run goes on without this launcher" in run.text
    assert runs_on(lab, left)
