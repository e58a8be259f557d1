"""`wait` for topics, services and nodes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain

WAIT = (sys.executable, "-m", "launcher", "wait")


@pytest.mark.thorough
def test_the_graph(tmp_path: Path):
    go = tmp_path / "go"
    words = ("--topic", "words", "--node", "/la*", "--service", "/late/get_parameters")
    with ros_domain(tmp_path / "log") as env:
        env["PYTHONPATH"] = str(REPOSITORY)
        short = subprocess.run(
            [*WAIT, *words, "--timeout", "3"],
            env=env,
            capture_output=True,
            text=True,
            check=False,
        )
        assert short.returncode == 124
        for missing in (
            "no publisher on /words",
            "no service /late/get_parameters",
            "no node /la*",
        ):
            assert missing in short.stderr
        with subprocess.Popen([*WAIT, *words, "--timeout", "60"], env=env) as waiting:
            node = [sys.executable, "-m", "tests.support.ready_node", "publisher", str(go)]
            go.touch()
            with subprocess.Popen([*node, "--ros-args", "-r", "__node:=late"], env=env) as late:
                code = waiting.wait(90)
                late.terminate()
    assert code == 0
