"""Nodes, verbs and log files where nothing can be written to the home folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.posix.socket_directory import NAME
from tests.support.benches import Bench
from tests.support.variations import few_of

pytest.importorskip("rclpy")

PROGRAM = """
import rclpy
rclpy.init()
rclpy.create_node('x').get_logger().info('it logs')
rclpy.shutdown()
"""
NODE = "__import__('launch_ros').actions.Node(executable=sys.executable, arguments=[{!r}])"


@pytest.fixture
def homeless(bench: Bench) -> Bench:
    """Without a folder for logs, for root as well."""
    bench.env = {**bench.env, "HOME": "/proc/none", "TMPDIR": str(bench.folder)}
    for name in ("ROS_LOG_DIR", "XDG_STATE_HOME"):
        bench.env.pop(name)
    (bench.folder / "node.py").write_text(PROGRAM)
    return bench


def run_node(bench: Bench, *words: str) -> subprocess.CompletedProcess[bytes]:
    return bench.run(NODE.format(str(bench.folder / "node.py")), *words)


def other_root(bench: Bench) -> Path:
    return bench.folder / f"{NAME}-{os.getuid()}" / "log"


WARNING = "warning: cannot write to the log folder /proc/none/.ros/log (No such file or directory)"


@pytest.mark.parametrize("words", few_of([(), ("--no-log-files",), ("--cold",)], [()]))
def test_nodes_run_and_log_where_the_warning_says(homeless: Bench, words: tuple[str, ...]):
    done = run_node(homeless, *words)
    out, err = done.stdout.decode(), done.stderr.decode()
    assert done.returncode == 0, out + err
    root = other_root(homeless)
    assert err.splitlines() == [f"{WARNING}: logs go to {root}; ROS_LOG_DIR chooses another"]
    run = root
    if "--no-log-files" not in words:
        run = root / "latest"
        assert f"All log files can be found below {root}/" in out
        assert "it logs" in (run / "launch.log").read_text()
    (own,) = run.glob("python*_*.log")
    assert "it logs" in own.read_text()


def verb(homeless: Bench, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "launcher", *words],
        env=homeless.env,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.thorough
def test_verbs_run_and_find_the_files_of_the_last_run(homeless: Bench):
    run_node(homeless)
    for words, text in (
        (("topic", "echo", "/x", "std_msgs/msg/String", "--timeout", "1"), ""),
        (("analyze",), f"log files: {other_root(homeless)}/"),
        (("logs",), f"{other_root(homeless)}/"),
    ):
        done = verb(homeless, *words)
        assert text in done.stdout + done.stderr
        assert (WARNING in done.stderr) is (words[0] == "topic"), "only what writes logs warns"


def test_run_starts_a_node(homeless: Bench):
    prefix = f"{sys.executable} {homeless.folder / 'node.py'}"
    words = ["run", "--prefix", prefix, "group_gp1", "monitor"]
    done = verb(homeless, *words)
    assert done.returncode == 0, done.stderr
    assert WARNING in done.stderr and "it logs" in done.stderr
