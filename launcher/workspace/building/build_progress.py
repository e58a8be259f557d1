"""What a build shows: one line that changes on a terminal, else a line per package."""

from __future__ import annotations

import re
import sys
import time
from dataclasses import dataclass, field
from typing import TextIO

from launcher.workspace.building.status_line import BuildStatusLine

_NINJA = re.compile(r"\[(\d+)/(\d+)\] (\w+)")  # NINJA_STATUS of `environment`
_STEPS = {"cmake": "configure", "build": "compile", "install": "install"}
_COMPILES = ("Building", "Linking")


@dataclass
class _Job:
    started: float
    step: str = "prepare"
    done: str = ""

    def __str__(self) -> str:
        return f"{self.step} {self.done}".rstrip()


@dataclass
class Progress:
    """The display of a build of `total` packages.

    It has a line that changes if the stream is a terminal that is wide enough; `quiet` if colcon
    itself writes to the terminal.
    """

    total: int
    note: str = ""
    quiet: bool = False
    stream: TextIO = field(default_factory=lambda: sys.stdout)
    _jobs: dict[str, _Job] = field(default_factory=dict)
    _finished: int = 0
    _began: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self._line = BuildStatusLine(self.stream)

    def start(self, package: str) -> None:
        self._jobs[package] = _Job(time.monotonic())
        self.refresh()

    def step(self, package: str, name: str) -> None:
        if package in self._jobs:
            self._jobs[package].step = _STEPS.get(name, name)
            self._jobs[package].done = ""
        self.refresh()

    def line(self, package: str, text: str) -> None:
        """A line that a tool has written to its standard output."""
        job = self._jobs.get(package)
        match = _NINJA.match(text) if job and job.step in ("compile", "generate") else None
        if job and match:
            job.step = "compile" if match[3] in _COMPILES else "generate"
            job.done = f"{match[1]}/{match[2]}"
            self.refresh()

    def end(self, package: str, problem: str = "") -> None:
        """The package is built, or has the `problem`."""
        job = self._jobs.pop(package, None)
        self._finished += 1
        if job is not None:
            self.say(f"{package}: {problem or 'built'} ({time.monotonic() - job.started:.1f} s)")

    def say(self, text: str) -> None:
        """A line that stays."""
        self.clear()
        if not self.quiet:
            print(text, file=self.stream, flush=True)

    def refresh(self) -> None:
        """Write the line anew, with the time that has passed."""
        if self.quiet:
            return
        parts = [f"{name}: {job}" for name, job in self._jobs.items()]
        head = f"[{self._finished}/{self.total}] {time.monotonic() - self._began:.0f} s  "
        self._line.write(head + ", ".join(parts) + (f"  ({self.note})" if self.note else ""))

    def clear(self) -> None:
        self._line.clear()
