"""Recognising kills by the kernel's OOM killer."""

from pathlib import Path

import pytest

from launcher.run.monitor.oom import OomWatch


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/vmstat").write_text("pgfault 12\noom_kill 3\n")
    return tmp_path


def test_the_machines_counter_is_used_where_there_is_no_other(root: Path):
    watch = OomWatch(root)
    assert not watch.has_struck()
    (root / "proc/vmstat").write_text("oom_kill 4\n")
    assert watch.has_struck()
    assert not watch.has_struck()


def test_the_counter_of_our_own_control_group_is_preferred(root: Path):
    group = root / "sys/fs/cgroup/user.slice"
    group.mkdir(parents=True)
    (root / "proc/self/cgroup").write_text("0::/user.slice\n")
    (group / "memory.events").write_text("low 0\noom 1\noom_kill 0\n")
    watch = OomWatch(root)
    (root / "proc/vmstat").write_text("oom_kill 99\n")
    assert not watch.has_struck()
    (group / "memory.events").write_text("low 0\noom 1\noom_kill 1\n")
    assert watch.has_struck()


def test_an_unreadable_counter_never_reports_a_kill(tmp_path: Path):
    assert not OomWatch(tmp_path).has_struck()
