"""A process in other namespaces."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from tests.support.children import children
from tests.support.waiting import wait_until


class Entered(subprocess.Popen):
    """A command under nsenter(1), which forks to enter a pid namespace and passes no signals on."""

    def __init__(self, command: Sequence[str], *, is_forked: bool, **options: Any) -> None:
        self._is_forked = is_forked
        super().__init__(command, **options)

    @property
    def inside(self) -> int:
        """Pid of the command itself, as the machine counts; 0 if it has ended."""
        if not self._is_forked:
            return self.pid
        wait_until(lambda: children(self.pid) or self.poll() is not None, "nsenter forks")
        return next(iter(children(self.pid)), 0)

    def send_signal(self, sig: int) -> None:
        """Send the signal to the command itself."""
        pid = self.inside if self.poll() is None else 0
        with suppress(ProcessLookupError):
            if pid:
                os.kill(pid, sig)
