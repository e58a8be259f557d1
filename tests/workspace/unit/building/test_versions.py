"""The versions that count for a build."""

from __future__ import annotations

import sys

import pytest

from launcher.workspace.building.toolchain.versions import fingerprint, interfaces


@pytest.mark.parametrize(
    "name", ["ros_std_msgs", "ros_jazzy_rclpy", "numpy", "colcon_core", "ros2_launcher"]
)
def test_another_version_counts(name, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    before = fingerprint()
    (tmp_path / f"{name}-99.0.dist-info").mkdir()
    assert fingerprint() != before


def test_other_distributions_do_not_count(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    before = fingerprint()
    (tmp_path / "requests-99.0.dist-info").mkdir()
    assert fingerprint() == before


def test_messages_of_other_prefixes_count(tmp_path):
    assert interfaces([str(tmp_path), sys.prefix]) == ""

    path = tmp_path / "share/low_msgs/msg/A.idl"
    path.parent.mkdir(parents=True)
    path.write_text("before")
    before = interfaces([str(tmp_path)])
    path.write_text("after")
    assert before != interfaces([str(tmp_path)]) != ""
