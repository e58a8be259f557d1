"""Fixture of a folder in which command lines are parsed."""

from __future__ import annotations

from pathlib import Path

import pytest

LAUNCH_FILE = """
from launch import LaunchDescription

def generate_launch_description():
    return LaunchDescription([])
"""


@pytest.fixture
def command_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `a.launch.py`, in which the words are read."""
    (tmp_path / "a.launch.py").write_text(LAUNCH_FILE, encoding="utf-8")
    (tmp_path / "e.yaml").write_text("expect:\n  - {node: /from_file}\n", encoding="utf-8")
    (tmp_path / "budgets.yaml").write_text("x: {fds: 9, nice: 3}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path
