"""That nodes were run by a Python without rclpy, where the launcher's own has it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import ProcessSpec
from launcher.packages import absent_ros
from launcher.run.logs.lacking_rclpy import lacking
from launcher.run.processes.machine_events import ReportExit
from launcher.run.processes.process import Process

ERROR = b"Traceback (most recent call last):\nModuleNotFoundError: No module named 'rclpy'\n"
OTHER = b"ModuleNotFoundError: No module named 'rclpy_message_converter'\n"


@pytest.fixture
def other(tmp_path: Path) -> str:
    """Another Python, and a script for the first one in PATH."""
    (tmp_path / "python3").symlink_to(os.path.realpath(sys.executable))
    (tmp_path / "talker.py").write_text("#!/usr/bin/env python3\nimport rclpy\n")
    (tmp_path / "talker.py").chmod(0o755)
    return str(tmp_path)


def died(*argv: str, path: str, output: bytes = ERROR, name: str = "talker-1") -> Process:
    spec = ProcessSpec(name=name, label=name, argv=argv, env={"PATH": path})
    one = Process(1, spec, number=1, prefix=b"")
    one.last_end = ReportExit(Outcome(returncode=1), asked=False, retry_in_s=None)
    one.history.deaths = 1
    one.ring.append("stderr", 1.0, output)
    return one


def test_the_interpreter_and_the_one_with_rclpy_are_named_once(other: str):
    text = lacking(
        [
            died(f"{other}/talker.py", path=other),
            died("python3", "x.py", path=other, name="listener-2"),
        ]
    )

    assert text is not None
    assert text.startswith(f"talker-1, listener-2 were run by {other}/python3, which has no rclpy")
    assert f"{sys.executable} has: " in text
    assert f"write '#!{sys.executable}' into its first line" in text


def test_nothing_is_said_of_others(other: str, monkeypatch: pytest.MonkeyPatch):
    script = f"{other}/talker.py"
    ours = os.path.dirname(sys.executable)

    assert lacking([died(script, path=other, output=OTHER)]) is None
    assert lacking([died(script, path=ours)]) is None
    assert lacking([died("/bin/true", path=other)]) is None
    monkeypatch.setattr(absent_ros, "is_installed", lambda name: False)
    assert lacking([died(script, path=other)]) is None
