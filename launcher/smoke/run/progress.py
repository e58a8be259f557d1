"""Narrator: tells how a smoke run goes, line by line, on the screen and in `smoke.log`."""

from __future__ import annotations

import contextlib
import io
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, TextIO

from launcher.smoke.expect.expectation import Expectation, Outcome, Verdict
from launcher.smoke.expect.quantities import printable, seconds_text
from launcher.smoke.expect.script import Script
from launcher.smoke.observe.facts import Ending, Facts
from launcher.smoke.run.system import System

_GREEN, _RED, _DIM, _PLAIN = "\x1b[32m", "\x1b[31m", "\x1b[2m", "\x1b[0m"
_COLOURS = {Outcome.MET: _GREEN, Outcome.VIOLATED: _RED, Outcome.OPEN: ""}


class Progress:
    """`screen` None: only the file. Threads may speak at the same time."""

    def __init__(self, folder: Path, screen: IO[str] | None, *, colour: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file = (folder / "smoke.log").open("w", encoding="utf-8")
        self._screen = screen
        self._colour = colour
        self._lock = threading.Lock()
        self.trouble: str | None = None

    def close(self) -> None:
        """Nothing more is told."""
        with self._lock, contextlib.suppress(OSError):  # what it has not written it has told
            self._file.close()

    def say(self, at_s: float, text: str, colour: str = "") -> None:
        """A line with the time of the run."""
        head, text = f"[{at_s:6.1f} s]", printable(text)
        with self._lock:
            self._write(f"{head} {text}\n")
            if self._screen is not None:
                self._screen.write(self._line(head, text, colour))
                self._screen.flush()

    def _write(self, line: str) -> None:
        """Into the file; a disk that refuses is said once and then left alone."""
        if self._file.closed or self.trouble is not None:
            return
        try:
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            self.trouble = f"smoke.log is not whole: {error.strerror}"
            if self._screen is not None:
                self._screen.write(f"smoke: {self.trouble}\n")

    def _line(self, head: str, text: str, colour: str) -> str:
        if not self._colour:
            return f"{head} {text}\n"
        shown = f"{colour}{text}{_PLAIN}" if colour else text
        return f"{_DIM}{head}{_PLAIN} {shown}\n"

    def begin(self, script: Script, words: Sequence[str], run_time_s: float) -> None:
        """What is going to happen."""
        count = sum(not e.implicit for e in script.expectations)
        noun = "expectation" if count == 1 else "expectations"
        self.say(0.0, f"{' '.join(words)}: {count} {noun}, watched for {seconds_text(run_time_s)}")
        if script.chaos is not None:
            self.say(0.0, f"chaos: {script.chaos.text}, seed {script.chaos.seed}")

    def started(self, system: System) -> None:
        """Where it happens."""
        self.say(0.0, f"started in ROS domain {system.domain_id}, evidence in {system.folder}")

    def decided(self, at_s: float, expectation: Expectation, verdict: Verdict) -> None:
        """An expectation is met or not."""
        word = "met     " if verdict.outcome is Outcome.MET else "NOT MET "
        seen = f": {verdict.seen}" if verdict.seen else ""
        self.say(at_s, f"{word} {expectation.name}{seen}", _COLOURS[verdict.outcome])

    def ended(self, at_s: float, ending: Ending, facts: Facts) -> None:
        """How it came down."""
        code = "killed" if ending.returncode is None else f"exit code {ending.returncode}"
        took_s = ending.down_s - facts.stop_s
        how = f"stopped in {seconds_text(took_s)}" if ending.asked_s is not None else "had ended"
        self.say(at_s, f"the system {how} ({code})")
        for process in ending.left_processes:
            self.say(at_s, f"left behind, and killed by us: {process}", _RED)


class PipeSafeStdout(io.TextIOBase):
    """Writes to a stream until that refuses, and is silent afterwards.

    A reader that has gone (`smoke ... | head`) is no failure; `trouble` tells any other.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_silent = False
        self.trouble: str | None = None

    @property
    def encoding(self) -> str:  # type: ignore[override]  # an attribute there
        """That of the stream, which decides what can be drawn."""
        return self._stream.encoding

    def write(self, text: str) -> int:
        """All of it, or as much as somebody takes."""
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Now."""
        self._attempt(self._stream.flush)

    def isatty(self) -> bool:
        """Whether the stream is a terminal."""
        return self._stream.isatty()

    def _attempt(self, work: Callable[[], object]) -> None:
        if self._is_silent:
            return
        try:
            work()
        except BrokenPipeError:
            self._is_silent = True
        except OSError as error:
            self._is_silent = True
            self.trouble = error.strerror
