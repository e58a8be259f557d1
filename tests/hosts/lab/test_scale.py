"""Ten hosts with four processes each: one of them cannot be reached, from the start or later."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support.hosts import Host, Lab
from tests.support.hosts.operator import launcher_words
from tests.support.waiting import wait_until

HOSTS, EACH = 10, 4
STARTED = "process started with pid"
MARK = "86399"  # in the words of the processes
LAUNCH_FILE = f"""
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=["sleep", "{MARK}"], name=f"host{{host}}_{{number}}")
        for host in range({HOSTS}) for number in range({EACH})
    ])
"""


class Run:
    """A run of the launcher on the operator, and what it has printed."""

    def __init__(self, process: subprocess.Popen[str], output: Path) -> None:
        self.process = process
        self._output = output

    @property
    def text(self) -> str:
        return self._output.read_text()

    def await_text(self, text: str, count: int = 1) -> None:
        wait_until(lambda: self.text.count(text) >= count or self.process.poll() is not None, text)
        assert self.text.count(text) >= count, self.text


@pytest.fixture(scope="module")
def hosts(lab: Lab) -> list[Host]:
    return [lab.host(f"scale{number}") for number in range(HOSTS)]


@contextmanager
def running(lab: Lab, hosts: list[Host], tmp_path: Path) -> Iterator[Run]:
    """Four processes on each host, which stops them when the operator is silent for six seconds."""
    file, output = lab.folder / "scale.launch.py", tmp_path / "output"
    file.write_text(LAUNCH_FILE)
    settings = {"engine": "ssh", "on_link_loss": "stop-after=6"}
    places = {f"process:host{number}_*": host.name for number, host in enumerate(hosts)}
    path = lab.hosts_file(lab.folder / "scale.yaml", dict.fromkeys(hosts, settings), places)
    words = launcher_words([file, "--hosts", path])
    with (
        output.open("w") as stdout,
        lab.operator.popen(words, stdout=stdout, stderr=subprocess.STDOUT) as process,
    ):
        try:
            yield Run(process, output)
        finally:
            process.kill()


def started(host: Host) -> int:
    return sum(MARK in process.words for process in host.processes())


def others(host: Host) -> list[str]:
    """What there is on a host besides sshd."""
    words = [" ".join(process.words) for process in host.processes()]
    return [text for text in words if "sshd" not in text]


def test_nothing_is_started_if_one_of_ten_hosts_cannot_be_reached(
    lab: Lab, hosts: list[Host], tmp_path: Path
):
    hosts[3].link_down()
    try:
        with running(lab, hosts, tmp_path) as run:
            assert run.process.wait(60) == 1
        assert f"scale3 (root@{hosts[3].address}) cannot be used" in run.text
        assert "exit code 1: cannot be used: scale3" in run.text
        assert STARTED not in run.text
        assert sum(map(started, hosts)) == 0
    finally:
        hosts[3].link_up()
    for host in hosts:
        wait_until(lambda host=host: not others(host), f"nothing is left on {host.name}")


def test_a_host_that_is_lost_is_named_and_nothing_is_left_on_any(
    lab: Lab, hosts: list[Host], tmp_path: Path
):
    with running(lab, hosts, tmp_path) as run:
        run.await_text(STARTED, HOSTS * EACH)
        assert [started(host) for host in hosts] == [EACH] * HOSTS
        hosts[7].link_down()
        try:
            run.await_text("scale7 is unreachable")
            assert "its processes are stopped there after 6 s" in run.text
            run.process.send_signal(signal.SIGINT)
            assert run.process.wait(60) == 1
            wait_until(lambda: started(hosts[7]) == 0, "the lost host has stopped its own")
        finally:
            hosts[7].link_up()
    assert "could not be reached: scale7 (host7_0-29, " in run.text
    names = {line.split()[1] for line in run.text.splitlines() if "is unreachable" in line}
    assert len(names) == 1
    for host in hosts:
        wait_until(lambda host=host: not others(host), f"nothing is left on {host.name}")
