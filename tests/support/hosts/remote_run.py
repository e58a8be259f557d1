"""A launcher on the operator's computer, whose screen can be waited for."""

from __future__ import annotations

import re
import signal
import subprocess
from pathlib import Path
from types import TracebackType
from typing import Any

from tests.support.hosts.lab import Lab
from tests.support.hosts.operator import launcher_words
from tests.support.waiting import wait_until


class RemoteRun:
    """Use `with`: it is killed at the end if it still runs."""

    def __init__(self, lab: Lab, screen: Path, *words: object, **options: Any) -> None:
        self._lab = lab
        self._screen = screen
        with open(screen, "wb") as file:
            self.process = lab.operator.popen(
                launcher_words([*words, "--no-console"]),
                stdout=file,
                stderr=subprocess.STDOUT,
                cwd=screen.parent,
                **options,
            )

    def __enter__(self) -> RemoteRun:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()

    @property
    def text(self) -> str:
        return self._screen.read_text(encoding="utf-8", errors="replace")

    def wait_for(self, pattern: str, times: int = 1) -> None:
        def is_there() -> bool:
            has_ended = self.process.poll() is not None  # before the text is read
            if len(re.findall(pattern, self.text, re.MULTILINE)) >= times:
                return True
            assert not has_ended, f"it has ended without {pattern!r}:\n{self.text}"
            return False

        try:
            wait_until(is_there, pattern)
        except AssertionError as error:
            raise AssertionError(f"{error}\n{self.text}") from None

    def numbers(self, name: str) -> list[int]:
        """The numbers that a process has counted."""
        return [int(one) for one in re.findall(rf"^\[{name}\] (\d+)$", self.text, re.MULTILINE)]

    def interrupt(self) -> int:
        """Ctrl-C; the exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self) -> int:
        return self.process.wait(60)
