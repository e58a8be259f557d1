"""Verbs that a script starts with `&`: its shell ignores SIGINT for them."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from launcher.posix import proc
from launcher.posix.ports import participants_by_domain
from tests.support.children import is_alive
from tests.support.variations import few_of
from tests.support.waiting import rest_of, wait_until

SCRIPT = '"$@" & echo $!; wait $!; echo exit code $?'
STRING = "std_msgs/msg/String"
VERBS = [
    "topic echo /a " + STRING,
    "topic hz /a",
    "topic bw /a",
    "topic pub /a " + STRING,
    "service call /a rcl_interfaces/srv/GetParameters",
    "graph --watch",
]


@contextlib.contextmanager
def in_background(
    env: Mapping[str, str], *words: str, cwd: Path | None = None
) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """(shell, pid of the verb), when the verb handles SIGINT."""
    command = [sys.executable, "-m", "launcher", *words]
    pipe = subprocess.PIPE
    with subprocess.Popen(
        ["sh", "-c", SCRIPT, "sh", *command], env=env, cwd=cwd, stdout=pipe, stderr=pipe, text=True
    ) as shell:
        assert shell.stdout is not None
        pid = int(shell.stdout.readline())
        try:
            wait_until(lambda: handles_sigint(pid), "it handles SIGINT")
            yield shell, pid
        finally:
            if is_alive(pid):
                os.kill(pid, signal.SIGKILL)


def handles_sigint(pid: int) -> bool:
    return bool(int(proc.status_field(pid, "SigCgt") or "0", 16) & 1 << signal.SIGINT - 1)


@pytest.mark.parametrize(
    "words", few_of(VERBS, VERBS[:2]), ids=lambda words: " ".join(words.split()[:2])
)
def test_a_verb_in_the_background_ends_by_sigint(empty_domain: dict[str, str], words: str):
    domain_id = int(empty_domain["ROS_DOMAIN_ID"])
    with in_background(empty_domain, *words.split()) as (shell, pid):
        wait_until(lambda: participants_by_domain()[domain_id], "it is in the domain")
        os.kill(pid, signal.SIGINT)
        out, err = rest_of(shell)
    assert out.endswith(("exit code 130\n", "exit code 0\n"))
    assert "Traceback" not in err
