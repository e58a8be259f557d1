"""Runs the tools of the machine: ip, ssh-keygen, mount."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence

TIMEOUT_S = 60.0


class ToolError(Exception):
    """A tool failed; the text has its command and what it printed."""


def run_tool(*words: object, timeout_s: float = TIMEOUT_S) -> str:
    """What the command printed; raises ToolError if it fails."""
    command = [str(word) for word in words]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout_s
    )
    if done.returncode:
        raise ToolError(failure(command, done))
    return done.stdout


def failure(command: Sequence[str], done: subprocess.CompletedProcess[str]) -> str:
    """The command, its exit code, and what it printed."""
    return f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
