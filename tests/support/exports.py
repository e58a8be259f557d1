"""Exports of the fleet, made by the command."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.support.repository import REPOSITORY

FLEET = REPOSITORY / "launch" / "system.launch.py"
TOOLS = REPOSITORY / "build" / "export-tools"  # made by .ci/run
COMPOSE_SCHEMA = TOOLS / "package" / "lib" / "schema.json"
ROBOTS = ("robot_1", "robot_2", "robot_3")


def export(
    engine: str,
    folder: Path,
    *words: str,
    target: Path = FLEET,
    env: Mapping[str, str] | None = None,
) -> str:
    """Export the target to the folder; what was written to standard error."""
    command = [
        sys.executable,
        "-m",
        "launcher",
        "export",
        engine,
        str(target),
        "--out",
        str(folder),
    ]
    done = subprocess.run(
        [*command, *words],
        env={**os.environ, "PYTHONPATH": str(REPOSITORY), **(env or {})},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def works(report: str) -> bool:
    """Whether a report of the fleet has finished tasks of all robots."""
    return all(f"{robot}: " in report and f"{robot}: 0 " not in report for robot in ROBOTS)


def tool(name: str) -> str:
    """The path of a program of requirements/export.txt; the test is skipped without it."""
    path = os.pathsep.join((str(TOOLS / "bin"), os.environ.get("PATH", os.defpath)))
    found = shutil.which(name, path=path)
    if found is None:
        pytest.skip(f"not installed: {name} (pip install -r requirements/export.txt)")
    return found
