"""A System starts, observes and ends real processes."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest

from launcher.base.model.run_events import Ended
from launcher.smoke import NotSeenError, System

HEAD = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def sh(name, script, **options):
    return ExecuteProcess(cmd=["sh", "-c", script], name=name, output="screen", **options)

def generate_launch_description():
    return LaunchDescription([
"""
PATIENT = 'sh("patient", "echo here I am; exec sleep 1000"),'
SHORT = 'sh("short", "echo last words; exit 3"),'


def launch_file(folder: Path, *actions: str) -> str:
    path = folder / "tested.launch.py"
    body = "\n".join(textwrap.indent(action, "        ") for action in actions)
    path.write_text(f"{HEAD}{body}\n    ])\n", encoding="utf-8")
    return str(path)


def system_of(folder: Path, *actions: str) -> System:
    return System([launch_file(folder, *actions)], folder=folder / "evidence", probe=False)


def test_lines_and_exits_of_processes_are_observed(tmp_path: Path):
    with system_of(tmp_path, PATIENT, SHORT) as system:
        line = system.wait_for_log("here I am", process="patient", within_s=60)
        end = system.wait_for_exit("short", within_s=60)
    assert line.process == "patient-1"
    assert end.event.returncode == 3 and not end.event.asked


def test_a_wait_in_vain_is_an_error_with_the_last_lines(tmp_path: Path):
    with system_of(tmp_path, PATIENT) as system:
        system.wait_for_log("here I am", within_s=60)
        with pytest.raises(NotSeenError, match=r"(?s)'nowhere'.*here I am"):
            system.wait_for_log("nowhere", within_s=0.2)


def test_stop_ends_all_processes_and_leaves_nothing(tmp_path: Path):
    with system_of(tmp_path, PATIENT) as system:
        system.wait_for_log("here I am", within_s=60)
    ending = system.stop()
    assert ending.returncode == 0
    assert (ending.left_processes, ending.left_memory) == ((), ())


def test_a_signal_from_outside_is_an_unexpected_exit_and_a_stop_is_not(tmp_path: Path):
    other = 'sh("other", "echo there; exec sleep 1000"),'
    with system_of(tmp_path, PATIENT, other) as system:
        system.wait_for_log("here I am", within_s=60)
        system.wait_for_log("there", within_s=60)
        system.kill("patient")
        killed = system.wait_for_exit("patient", within_s=60)
        system.control("stop", "other")
        stopped = system.wait_for_exit("other", within_s=60)
    assert killed.event.returncode == -9 and not killed.event.asked
    assert stopped.event.asked


def test_a_run_that_ends_at_once_has_reported_everything(tmp_path: Path):
    with system_of(tmp_path, SHORT) as system:
        system.wait_for(lambda facts: not system.is_alive, "the launcher ends", 60)
    facts = system.facts()
    assert [e.event.returncode for e in facts.of(Ended)] == [3]
    assert [line.text for line in facts.lines if line.process == "short-1"] == ["last words"]


def test_two_systems_have_domains_of_their_own(tmp_path: Path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    with system_of(tmp_path / "a", PATIENT) as one, system_of(tmp_path / "b", PATIENT) as two:
        assert one.domain_id != two.domain_id
        assert one.environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
