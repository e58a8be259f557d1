"""Processes of an agent over ssh: a broken link, killed ends, more than sshd has sessions."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.support.hosts import Host, Lab
from tests.support.hosts.remote_run import RemoteRun
from tests.support.hosts.run import agents
from tests.support.waiting import wait_until

COUNT = "n=0; while :; do n=$((n+1)); echo $n; sleep 0.1; done"
DEFAULT_SESSIONS = 10  # of sshd on a connection

Start = Callable[..., RemoteRun]


@pytest.fixture(scope="module")
def host(lab: Lab) -> Host:
    return lab.host("bot1")


@pytest.fixture
def start(lab: Lab, host: Host, tmp_path: Path) -> Iterator[Start]:
    """Starts a launcher on `NAME="shell script"`."""
    runs: list[RemoteRun] = []

    def begin(on_link_loss: str = "keep", **processes: str) -> RemoteRun:
        folder = tmp_path / str(len(runs))
        folder.mkdir()
        settings = {"engine": "ssh", "on_link_loss": on_link_loss}
        lab.hosts_file(folder / "hosts.yaml", {host: settings}, {"*": host.name})
        (folder / "t.launch.py").write_text(launch_file(processes), encoding="utf-8")
        run = RemoteRun(lab, folder / "screen", "t.launch.py", "--hosts", "hosts.yaml")
        runs.append(run)
        return run

    yield begin
    for run in runs:
        run.__exit__(None, None, None)
    wait_until(lambda: not agents(host), "the agents end")


def launch_file(processes: dict[str, str]) -> str:
    actions = [
        f"ExecuteProcess(cmd=['/bin/sh', '-c', {script!r}], name={name!r}, output='screen')"
        for name, script in processes.items()
    ]
    return (
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n"
        "def generate_launch_description():\n"
        f"    return LaunchDescription([{', '.join(actions)}])\n"
    )


def scripts(host: Host) -> list[int]:
    return [one.pid for one in host.processes() if COUNT in one.words]


def without_gap(numbers: list[int]) -> bool:
    return numbers == list(range(1, len(numbers) + 1))


@pytest.mark.parametrize("policy", ["keep", "stop-after=60 s"])
def test_nothing_is_lost_while_the_link_is_down(host: Host, start: Start, policy: str):
    run = start(policy, counter=COUNT)
    run.wait_for(r"^\[counter-1\] 5$")
    host.link_down()
    run.wait_for("bot1 is unreachable")
    before = run.numbers("counter-1")[-1]
    host.link_up()
    run.wait_for("bot1 is reachable again")
    run.wait_for(rf"^\[counter-1\] {before + 40}$")
    assert run.interrupt() == 0
    assert without_gap(run.numbers("counter-1")), run.text


@pytest.mark.parametrize("victim", ["ssh", "sshd"])
def test_a_killed_connection_is_replaced_and_no_line_is_lost(
    lab: Lab, host: Host, start: Start, victim: str
):
    run = start(counter=COUNT)
    run.wait_for(r"^\[counter-1\] 5$")
    if victim == "ssh":
        (pid,) = [p.pid for p in lab.operator.processes() if p.words[:2] == ("ssh", "-T")]
        os.kill(pid, signal.SIGKILL)
    else:
        host.kill_sshd_sessions()
    run.wait_for("bot1 is reachable again")
    seen = run.numbers("counter-1")[-1]
    run.wait_for(rf"^\[counter-1\] {seen + 20}$")
    assert run.interrupt() == 0
    assert without_gap(run.numbers("counter-1")), run.text


def test_a_killed_agent_takes_its_processes_along(host: Host, start: Start):
    run = start(counter=COUNT)
    run.wait_for(r"^\[counter-1\] 5$")
    (agent,) = agents(host)
    os.kill(agent, signal.SIGKILL)

    assert run.wait() == 1
    assert "counter-1 ended unexpectedly (lost with bot1)" in run.text
    wait_until(lambda: not scripts(host), "its watchdog ends them")


def test_a_killed_launcher_leaves_its_processes_to_the_leash(host: Host, start: Start):
    run = start("stop-after=6 s", counter=COUNT)
    run.wait_for(r"^\[counter-1\] 5$")
    run.process.kill()
    assert scripts(host)
    wait_until(lambda: not scripts(host), "the host stops them")


PIECES = """exec python3 -c '
import os, time
lines = (b"{0}" * 999 + b"\\n") * 400
for at in range(0, len(lines), 7001):
    os.write(1, lines[at : at + 7001])
    time.sleep(0.02)
'"""


def test_lines_stay_whole_although_their_pieces_come_late(host: Host, start: Start):
    """Several seconds of a slow link are between the host and the screen."""
    host.slow_link(bytes_per_s=100_000)
    try:
        run = start(a=PIECES.format("a"), b=PIECES.format("b"))
        assert run.wait() == 0
    finally:
        host.normal_link()
    for name, letter in (("a-1", "a"), ("b-2", "b")):
        lines = [line for line in run.text.splitlines() if line.startswith(f"[{name}]")]
        assert lines == [f"[{name}] {letter * 999}"] * 400


def test_a_host_has_more_processes_than_sshd_has_sessions(host: Host, start: Start):
    many = DEFAULT_SESSIONS + 4
    run = start(**{f"p{number}": "echo up; exec sleep 1000" for number in range(many)})
    run.wait_for(r"^\[p\d+-\d+\] up$", many)
    assert run.interrupt() == 0


def test_two_runs_on_a_host_do_not_see_each_other(host: Host, start: Start):
    first, second = start(first=COUNT), start(counter=COUNT)
    first.wait_for(r"^\[first-1\] 5$")
    second.wait_for(r"^\[counter-1\] 5$")
    assert first.interrupt() == 0
    seen = second.numbers("counter-1")[-1]
    second.wait_for(rf"^\[counter-1\] {seen + 10}$")
    assert second.interrupt() == 0
    assert without_gap(second.numbers("counter-1")), second.text
