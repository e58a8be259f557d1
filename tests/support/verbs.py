"""Run a ROS verb of the launcher and keep what it printed."""

from __future__ import annotations

import contextlib
import io
import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from launcher.cli import dispatch as cli
from tests.support.node_process import without_complaints
from tests.support.waiting import wait_until

TIMEOUT_S = 60.0


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
    stdin, sys.stdin = sys.stdin, io.TextIOWrapper(io.BytesIO((text or "").encode()))
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = cli.main(words)
    finally:
        sys.stdin = stdin
        for signum, handler in handlers.items():
            signal.signal(signum, handler)
    return Answer(out=out.getvalue(), err=err.getvalue(), code=int(code))


def launcher(
    env: Mapping[str, str], *words: str, text: str | None = None, cwd: Path | None = None
) -> Answer:
    """`python -m launcher WORDS`, to its end."""
    done = subprocess.run(
        [sys.executable, "-m", "launcher", *words],
        env=dict(env),
        cwd=cwd,
        input=text,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
    )
    out, err = map(without_complaints, (done.stdout, done.stderr))
    return Answer(out=out, err=err, code=done.returncode)


def eventually(ask: Callable[[], Answer], fits: Callable[[Answer], object]) -> Answer:
    """Run a verb again until its answer fits; for verbs that measure for a few seconds only."""
    answers: list[Answer] = []

    def is_there() -> bool:
        answers.append(ask())
        return bool(fits(answers[-1]))

    try:
        wait_until(is_there, "an answer that fits")
    except AssertionError as error:
        raise AssertionError(f"{error}; the last one is {answers[-1]}") from None
    return answers[-1]


@contextlib.contextmanager
def going_on(
    env: Mapping[str, str], *words: str, cwd: Path | None = None
) -> Iterator[subprocess.Popen[str]]:
    """A verb that runs until it is interrupted."""
    command = [sys.executable, "-m", "launcher", *words]
    program = subprocess.Popen(command, env=env, cwd=cwd, stdout=subprocess.PIPE, text=True)
    try:
        yield program
    finally:
        program.send_signal(signal.SIGINT)
        program.communicate(timeout=TIMEOUT_S)
