"""When a node counts as not responding."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.posix import proc
from launcher.ros.helpers.responsiveness import SILENT_S, WatchedNode


@pytest.fixture
def waited(tmp_path: Path, monkeypatch):
    """Sets how long the process has waited for a processor."""
    (tmp_path / "7").mkdir()
    monkeypatch.setattr(proc, "ROOT", str(tmp_path))

    def wait(seconds: float) -> None:
        (tmp_path / "7/schedstat").write_text(f"123 {int(seconds * 1e9)} 4\n")

    wait(5.0)
    return wait


@pytest.fixture
def node(waited) -> WatchedNode:
    one = WatchedNode("arm-1", 7)
    assert one.answered()
    return one


def test_a_node_is_silent_after_three_seconds_without_an_answer(node):
    for _ in range(2):
        node.no_answer(1.0)
    assert not node.is_silent
    node.no_answer(1.0)
    assert node.is_silent
    assert node.silent_s == SILENT_S
    assert node.answered()
    assert not node.is_silent
    assert not node.answered()  # which is nothing new


def test_a_node_that_never_answered_is_starting_or_has_no_services(waited):
    node = WatchedNode("arm-1", 7)
    for _ in range(10):
        node.no_answer(1.0)
    assert not node.is_silent


def test_time_that_its_process_waits_for_a_processor_does_not_count(node, waited):
    for number in range(1, 11):
        waited(5.0 + 0.9 * number)
        node.no_answer(1.0)
    assert node.silent_s == pytest.approx(1.0)


def test_our_own_delay_does_not_count(node):
    node.no_answer(60.0)
    assert not node.is_silent


def test_a_node_whose_service_is_gone_has_to_answer_again_first(node):
    for _ in range(5):
        node.no_answer(1.0)
    node.lost()
    assert not node.is_silent
    for _ in range(5):
        node.no_answer(1.0)
    assert not node.is_silent


def test_a_process_whose_times_cannot_be_read(tmp_path, monkeypatch):
    monkeypatch.setattr(proc, "ROOT", str(tmp_path))
    node = WatchedNode("arm-1", 8)
    node.answered()
    for _ in range(3):
        node.no_answer(1.0)
    assert node.is_silent
