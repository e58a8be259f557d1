"""Verbs from the shell: processor time against `python -c pass`, and how much is imported."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import partial
from typing import IO

from benchmarks.contestant import REPOSITORY, installed_command, shell_environment
from benchmarks.harness import Row, interleaved, median, milliseconds, ratio

LIMITS = {
    "--help": 1.5,
    "ps": 1.5,
    "topic list --help": 1.5,
    "smoke --help": 1.5,
    "pkg list": 2.0,
    "plan system": 2.0,
}


def verbs(runs: int) -> list[Row]:
    """Each verb with the installed command, and the bare interpreter as a shell starts it."""
    command = installed_command()
    words = {verb: [command, *verb.split()] for verb in LIMITS}
    all_words = {"bare": [sys.executable, "-c", "pass"], **words}
    found = interleaved(runs, {name: partial(_cpu_s, one) for name, one in all_words.items()})
    bare = found["bare"]
    return [
        Row(
            f"CPU of `{verb}`",
            ratio(found[verb], bare),
            "x",
            limit,
            f"{milliseconds(found[verb])}, python -c pass {median(bare) * 1000:.3g} ms, "
            f"{_modules(words[verb])} modules",
        )
        for verb, limit in LIMITS.items()
    ]


def _started(
    words: list[str], stderr: int | IO[bytes] = subprocess.DEVNULL, **variables: str
) -> subprocess.Popen[bytes]:
    """A command in the repository; its output goes nowhere."""
    env = {**shell_environment(), **variables}
    return subprocess.Popen(
        words, cwd=REPOSITORY, env=env, stdout=subprocess.DEVNULL, stderr=stderr
    )


def _cpu_s(words: list[str]) -> float:
    """Processor time of a command and of what it waits for."""
    process = _started(words)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return used.ru_utime + used.ru_stime


def _modules(words: list[str]) -> int:
    """How many modules the command imports."""
    with _started(words, subprocess.PIPE, PYTHONPROFILEIMPORTTIME="1") as process:
        _, text = process.communicate()
    return sum(line.startswith(b"import time:") for line in text.splitlines()) - 1  # the headline
