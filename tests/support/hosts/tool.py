"""Runs the tools of the machine: ip, ssh-keygen, mount."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence

TIMEOUT_S = 60.0


class ToolError(Exception):
    """A tool failed; the text has its command and what it printed, `complaint` the end of it."""

    def __init__(self, command: Sequence[str], done: subprocess.CompletedProcess[str]) -> None:
        super().__init__(failure(command, done))
        self.complaint = " / ".join(done.stderr.split("\n")[:-1][-3:])


def run_tool(*words: object, timeout_s: float = TIMEOUT_S) -> str:
    """What the command printed; raises ToolError if it fails."""
    command = [str(word) for word in words]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout_s
    )
    if done.returncode:
        raise ToolError(command, done)
    return done.stdout


def failure(command: Sequence[str], done: subprocess.CompletedProcess[str]) -> str:
    """The command, its exit code, and what it printed."""
    return f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
