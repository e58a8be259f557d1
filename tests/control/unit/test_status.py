"""Rows of processes for `ps` and `top`."""

from __future__ import annotations

import os
from types import SimpleNamespace
from typing import Any

import pytest

from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.control import status
from launcher.posix import proc
from launcher.run.processes.process import Process


@pytest.fixture
def process() -> Process:
    """A process whose child is this one, which is not suspended."""
    ros = RosIdentity(package="p", executable="e", node_name="robot_1", namespace="/fleet")
    spec = ProcessSpec(name="robot_1-1", label="robot", argv=("robot",), env={}, ros=ros)
    found = Process(1, spec, number=0, prefix=b"")
    found.child = SimpleNamespace(pid=os.getpid())  # type: ignore[assignment]
    return found


@pytest.fixture
def run() -> Any:
    """What rows need of a run."""
    keeper, reactor = SimpleNamespace(sample_of=lambda process: None), SimpleNamespace(now=float)
    return SimpleNamespace(housekeeper=keeper, reactor=reactor, parts=())


def test_the_rows_of_top_are_made_without_a_look_into_proc(
    run: Any, process: Process, monkeypatch: pytest.MonkeyPatch
):
    process.saw_state(is_suspended=True)
    monkeypatch.setattr(proc, "read", lambda *words: pytest.fail("it was read"))
    (row,) = status.rows(run, [process], looks=False)
    assert row["paused"]
    assert (row["node_names"], row["namespace"]) == (["/fleet/robot_1"], "/fleet")


def test_what_a_row_of_ps_has_seen_is_what_top_shows(run: Any, process: Process):
    process.saw_state(is_suspended=True)
    assert not status.rows(run, [process])[0]["paused"]
    assert not status.rows(run, [process], looks=False)[0]["paused"]


def test_a_new_child_is_not_suspended_because_the_last_one_was(run: Any, process: Process):
    process.saw_state(is_suspended=True)
    process.child = SimpleNamespace(pid=1)  # type: ignore[assignment]
    assert not status.rows(run, [process], looks=False)[0]["paused"]
