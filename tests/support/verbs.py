"""Run a ROS verb of the launcher and keep what it printed."""

from __future__ import annotations

import contextlib
import io
import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from launcher import cli

PATIENCE_S = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What a command printed, and its exit code."""

    out: str
    err: str
    code: int

    @property
    def lines(self) -> list[str]:
        return self.out.splitlines()

    def json(self) -> Any:
        return json.loads(self.out)


def in_process(*words: str, text: str | None = None) -> Answer:
    """The same in this process and its environment, which saves the start of an interpreter."""
    out, err = io.StringIO(), io.StringIO()
    handlers = {signum: signal.getsignal(signum) for signum in (signal.SIGTERM, signal.SIGHUP)}
    stdin, sys.stdin = sys.stdin, io.StringIO(text or "")
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = cli.main(words)
    finally:
        sys.stdin = stdin
        for signum, handler in handlers.items():
            signal.signal(signum, handler)
    return Answer(out=out.getvalue(), err=err.getvalue(), code=int(code))


def launcher(env: Mapping[str, str], *words: str, text: str | None = None) -> Answer:
    """`python -m launcher WORDS`, to its end."""
    done = subprocess.run(
        [sys.executable, "-m", "launcher", *words],
        env=dict(env),
        input=text,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    return Answer(out=done.stdout, err=done.stderr, code=done.returncode)
