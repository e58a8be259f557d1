"""Verbs from the shell: processor time against `python -c pass`, and how much is imported."""

from __future__ import annotations

import os
import sys
from functools import partial
from pathlib import Path

from benchmarks.contestant import HOOK, REPOSITORY, python_environment
from benchmarks.harness import NotHereError, Row, interleaved, median, milliseconds, ratio, scratch

COMMAND = Path(sys.executable).with_name("launcher")
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
    if not COMMAND.exists():
        raise NotHereError(f"{COMMAND} is not installed")
    bare = [sys.executable, "-c", "pass"]
    words = {verb: [str(COMMAND), *verb.split()] for verb in LIMITS}
    found = interleaved(
        runs, {name: partial(_cpu_s, words) for name, words in {"bare": bare, **words}.items()}
    )
    return [
        Row(
            f"CPU of `{verb}`",
            ratio(found[verb], found["bare"]),
            "x",
            limit,
            f"{milliseconds(found[verb])}, python -c pass {median(found['bare']) * 1000:.3g} ms, "
            f"{_modules(words[verb])} modules",
        )
        for verb, limit in LIMITS.items()
    ]


def _environment() -> dict[str, str]:
    return {name: value for name, value in python_environment().items() if name not in HOOK}


def _cpu_s(words: list[str]) -> float:
    """Processor time of a command and of what it waits for."""
    pid = _started(words, _environment(), os.devnull)
    _, _, used = os.wait4(pid, 0)
    return used.ru_utime + used.ru_stime


def _started(words: list[str], env: dict[str, str], errors: str) -> int:
    """The pid of a command in the repository; its output goes nowhere."""
    flags = os.O_WRONLY | os.O_CREAT
    files = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, flags, 0o600)]
    files += [(os.POSIX_SPAWN_OPEN, 2, errors, flags, 0o600)]
    before = os.getcwd()
    os.chdir(REPOSITORY)
    try:
        return os.posix_spawn(words[0], words, env, file_actions=files)
    finally:
        os.chdir(before)


def _modules(words: list[str]) -> int:
    """How many modules the command imports."""
    with scratch() as folder:
        errors = folder / "errors"
        env = {**_environment(), "PYTHONPROFILEIMPORTTIME": "1"}
        os.waitpid(_started(words, env, str(errors)), 0)
        lines = errors.read_text(encoding="utf-8", errors="replace").splitlines()
    return sum(line.startswith("import time:") for line in lines) - 1  # the headline
