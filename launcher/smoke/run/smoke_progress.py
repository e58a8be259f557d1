"""Progress of a smoke run, line by line, on standard output and in `smoke.log`."""

from __future__ import annotations

import contextlib
import io
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, TextIO

from launcher.base.document.quantities import seconds_text
from launcher.base.text import count, escape
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.expect.script import Script
from launcher.smoke.observe.facts import Ending, Facts

if TYPE_CHECKING:
    from launcher.smoke.run.system import System

_GREEN, _RED, _DIM, _PLAIN = "\x1b[32m", "\x1b[31m", "\x1b[2m", "\x1b[0m"


class SmokeProgress:
    """Writes lines from any thread; `trouble` is set if `smoke.log` cannot be written."""

    def __init__(self, folder: Path, screen: IO[str], *, colour: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file = (folder / "smoke.log").open("w", encoding="utf-8")
        self._screen = screen
        self._colour = colour
        self._lock = threading.Lock()
        self.trouble: str | None = None

    def close(self) -> None:
        with self._lock, contextlib.suppress(OSError):  # reported when it was written
            self._file.close()

    def log(self, at_s: float, text: str, colour: str = "") -> None:
        """A line with the time of the run."""
        head, text = f"[{at_s:6.1f} s]", escape(text)
        with self._lock:
            self._write(f"{head} {text}\n")
            if self._colour:
                head = f"{_DIM}{head}{_PLAIN}"
                text = f"{colour}{text}{_PLAIN}" if colour else text
            self._screen.write(f"{head} {text}\n")
            self._screen.flush()

    def _write(self, line: str) -> None:
        """Into the file; an error is reported once."""
        if self._file.closed or self.trouble is not None:
            return
        try:
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            self.trouble = f"smoke.log is incomplete: {error.strerror}"
            self._screen.write(f"smoke: {self.trouble}\n")

    def begin(self, script: Script, words: Sequence[str], run_time_s: float) -> None:
        wanted = count(len(script.expectations), "expectation")
        implied = [f"'{e.name}'" for e in script.expectations if e.implicit]
        if implied:
            wanted += f" with the implied {' and '.join(implied)}"
        self.log(0.0, f"{' '.join(words)}: {wanted}, observed for {seconds_text(run_time_s)}")
        if script.chaos is not None:
            self.log(0.0, f"chaos: {script.chaos.text}, seed {script.chaos.seed}")

    def started(self, system: System) -> None:
        self.log(0.0, f"started in ROS domain {system.domain_id}, evidence in {system.folder}")

    def decided(self, at_s: float, expectation: Expectation, verdict: Verdict) -> None:
        word, colour = (
            ("met     ", _GREEN) if verdict.outcome is Decision.MET else ("NOT MET ", _RED)
        )
        seen = f": {verdict.seen}" if verdict.seen else ""
        self.log(at_s, f"{word} {expectation.name}{seen}", colour)

    def ended(self, at_s: float, ending: Ending, facts: Facts) -> None:
        code = "killed" if ending.returncode is None else f"exit code {ending.returncode}"
        took_s = ending.down_s - facts.stop_s
        how = f"stopped in {seconds_text(took_s)}" if ending.asked_s is not None else "had exited"
        self.log(at_s, f"the system {how} ({code})")
        for process in ending.left_processes:
            self.log(at_s, f"left behind and killed: {process}", _RED)


class PipeSafeStdout(io.TextIOBase):
    """Writes to a stream until that fails, then discards the rest, so that a run ends in order.

    `trouble` is set for an error other than a closed pipe (`smoke ... | head`).
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_silent = False
        self.trouble: str | None = None

    @property
    def encoding(self) -> str:  # type: ignore[override]  # an attribute there
        return self._stream.encoding

    def write(self, text: str) -> int:
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        self._attempt(self._stream.flush)

    def isatty(self) -> bool:
        return self._stream.isatty()

    def _attempt(self, work: Callable[[], object]) -> None:
        if self._is_silent:
            return
        try:
            work()
        except OSError as error:
            self._is_silent = True
            if not isinstance(error, BrokenPipeError):
                self.trouble = error.strerror
