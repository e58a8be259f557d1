"""A System with processes on other hosts, over a link within the launcher's process."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.model.run_events import Ended
from launcher.smoke import System
from launcher.smoke.run import system_network
from launcher.smoke.run.launcher_process import LauncherProcess
from tests.smoke.process.test_system import PATIENT, launch_file
from tests.support.loopback.run import SWITCHES
from tests.support.waiting import wait_until


@pytest.fixture
def hosts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(LauncherProcess, "module", "tests.support.loopback.run")
    path = tmp_path / "hosts.yaml"
    path.write_text("hosts: {bot1: {address: 127.0.0.1}}\nplace: {patient: bot1}\n")
    return path


def test_a_crash_on_another_host_is_one_for_the_run(tmp_path: Path, hosts: Path):
    other = 'sh("other", "exec sleep 1000"),'
    words = [launch_file(tmp_path, PATIENT, other), "--hosts", str(hosts)]
    with System(words, folder=tmp_path / "evidence", probe=False) as system:
        system.wait_for_log("here I am", process="patient", within_s=60)
        system.kill("patient")
        end = system.wait_for_exit("patient", within_s=60)
        assert (end.event.returncode, end.event.asked, end.host) == (-9, False, "bot1")
    ending = system.stop()
    assert ending.returncode == 130
    assert ending.left_processes == ()


def test_a_lost_host_is_no_end_of_its_processes(tmp_path: Path, hosts: Path):
    fifo = tmp_path / "switches"
    os.mkfifo(fifo)
    words = [launch_file(tmp_path, PATIENT), f"--hosts={hosts}"]
    system = System(
        words,
        folder=tmp_path / "evidence",
        probe=False,
        environment={**os.environ, SWITCHES: str(fifo)},
    )
    with system:
        system.wait_for_log("here I am", process="patient", within_s=60)
        fifo.write_text("cut bot1\n")
        wait_until(lambda: system.ps()[0]["unreachable_s"] is not None, "a lost link")
        assert not list(system.facts().of(Ended, "patient"))
        fifo.write_text("restore bot1\n")
        system.wait_for_log("bot1 is reachable again", process="launch", within_s=60)
    assert system.stop().returncode == 0


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["a.launch.py"], {}),
        (["a.launch.py", "--hosts", "HOSTS"], {}),
        (["a.launch.py", "--hosts", "missing.yaml", "--discovery=peers"], {}),
        (["a.launch.py", "--hosts=HOSTS", "--discovery", "peers"], {"127.0.0.1"}),
    ],
)
def test_the_probe_discovers_as_the_nodes_do(hosts: Path, words: list[str], expected: object):
    words = [word.replace("HOSTS", str(hosts)) for word in words]
    is_local = "--hosts" not in " ".join(words)
    assert system_network.of_system(words)[system_network.RANGE] == (
        "LOCALHOST" if is_local else "SUBNET"
    )
    found = system_network.of_probe(words, os.environ)
    assert {found["ROS_STATIC_PEERS"]} == expected if expected else found == {}
