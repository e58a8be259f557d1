"""Small launch files, and the smoke command on them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

from tests.support.repository import REPOSITORY

TIMEOUT_S = 120
HEAD = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess, TimerAction

def sh(name, script, **options):
    return ExecuteProcess(cmd=["sh", "-c", script], name=name, output="screen", **options)

def py(name, script, **options):
    cmd = [sys.executable, "-u", "-c", script]
    return ExecuteProcess(cmd=cmd, name=name, output="screen", **options)

def generate_launch_description():
    return LaunchDescription([
"""
PATIENT = 'sh("patient", "echo here I am; exec sleep 1000"),'
SHORT = 'sh("short", "echo last words; exit 3"),'
DONE = 'sh("done", "echo done"),'
# Of a run that ends by itself everything was seen, however long it took.
BRIEF = 'sh("brief", "echo here I was"),'
DEAF = 'sh("deaf", "trap : INT TERM; echo deaf; while :; do sleep 0.1; done"),'
# SIGTERM and SIGKILL come soon.
IMPATIENT = ("sigterm_timeout:=0.3", "sigkill_timeout:=0.3")


def talking(name: str = "talker") -> str:
    """The action of a real node, tests.smoke.process.talking_node."""
    command = f'[sys.executable, "-m", "tests.smoke.process.talking_node", "{name}"]'
    return f'ExecuteProcess(cmd={command}, name="{name}", cwd="{REPOSITORY}", output="screen"),'


class Bench:
    """One launch file in a folder, and what came of smoke on it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.evidence = folder / "evidence"
        self.keeps_evidence = True
        self.launch_file = folder / "tested.launch.py"
        self.environment = {**os.environ, "ROS_LOG_DIR": str(folder / "elsewhere")}
        self.environment.pop("FORCE_COLOR", None)

    def write(self, *actions: str) -> None:
        body = "\n".join(textwrap.indent(action, "        ") for action in actions)
        self.launch_file.write_text(f"{HEAD}{body}\n    ])\n", encoding="utf-8")

    def expect(self, text: str) -> None:
        """The file beside the launch file."""
        path = self.folder / "tested.expect.yaml"
        path.write_text(textwrap.dedent(text), encoding="utf-8")

    def command(self, *words: str) -> list[str]:
        artifacts = [f"--artifacts={self.evidence}"] if self.keeps_evidence else []
        # 10 s by default if no node is waited for
        has_limit = any(word.startswith(("--ready-within", "--expect-node")) for word in words)
        patience = [] if has_limit else ["--ready-within=60"]
        words = (str(self.launch_file), *artifacts, *patience, *words)
        return [sys.executable, "-m", "launcher", "smoke", *words]

    def smoke(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            self.command(*words),
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
        )

    def start(self, *words: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            self.command(*words),
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def report(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads((self.evidence / "report.json").read_text("utf-8"))
        return found

    def outcomes(self) -> dict[str, str]:
        """Name of each expectation -> met or violated."""
        return {one["name"]: one["outcome"] for one in self.report()["expectations"]}

    def judged(self, name: str) -> dict[str, Any]:
        return next(one for one in self.report()["expectations"] if one["name"] == name)
