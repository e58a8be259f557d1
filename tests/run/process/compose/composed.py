"""Nodes of real programs as actions, and what their run says of them."""

from __future__ import annotations

import re
import signal
from pathlib import Path

from tests.support.controlled_run import ControlledRun
from tests.support.repository import REPOSITORY

PROGRAM = REPOSITORY / "tests/support" / "plain_node.py"
NODE = "__import__('launch_ros').actions.Node"
LOGGED = r"\[{}\] \[INFO\] \[[\d.]+\] \[{}\]: (.*)"


def plain(style: str, *, name: str | None = None, more: str = "") -> str:
    """The action that starts a plain node, which is named after its style."""
    name = name or style
    return (
        f"{NODE}(executable=sys.executable, arguments=[{str(PROGRAM)!r}, {style!r}, {name!r}], "
        f"exec_name={name!r}, output='screen'{more})"
    )


def script(path: Path, text: str) -> str:
    """The action that runs a Python program."""
    path.write_text(text, encoding="utf-8")
    name = path.stem
    return (
        f"{NODE}(executable=sys.executable, arguments=[{str(path)!r}], exec_name={name!r}, "
        "output='screen')"
    )


def logged(run: ControlledRun, process: str, node: str) -> list[str]:
    """What a node has logged so far, with the prefix of its process."""
    return re.findall(LOGGED.format(re.escape(process), re.escape(node)), run.screen)


def pid_of(run: ControlledRun, name: str = "composed-1") -> int:
    pid: int = run.row(name)["pid"]
    return pid


def end(run: ControlledRun, *, by: int = signal.SIGINT) -> None:
    run.process.send_signal(by)
    assert run.exit_code() == 0, run.screen


def tasks(run: ControlledRun, process: str) -> list[str]:
    return logged(run, process, process.rpartition("-")[0])
