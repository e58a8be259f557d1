"""Guard: our end of the watchdog. As long as it is open, a killed launcher leaves nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from launcher.engine.watchdog import GOODBYE

GOODBYE_S = 1.0  # a watchdog that does not go within this time is killed


class Guard:
    """Starts the watchdog for a run; `close()` says goodbye to it and waits for its end.

    `pidfd` becomes readable when somebody ends it; the run is not guarded any more then.
    """

    def __init__(self, run_id: str) -> None:
        script = Path(__file__).with_name("watchdog.py")
        # No run id in its own environment: it must not find itself.
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(script), run_id],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={k: v for k, v in os.environ.items() if k == "LD_LIBRARY_PATH"},
            cwd="/",
            start_new_session=True,
            bufsize=0,
        )
        self.pidfd = os.pidfd_open(self._process.pid)

    @property
    def pid(self) -> int:
        """The watchdog's pid."""
        return self._process.pid

    def close(self) -> None:
        """The run ended in order: nothing is to be killed."""
        assert self._process.stdin is not None
        try:
            os.write(self._process.stdin.fileno(), GOODBYE)
        except BrokenPipeError:
            pass  # somebody killed the watchdog; there is nothing to say goodbye to
        finally:
            self._process.stdin.close()
        try:
            self._process.wait(GOODBYE_S)
        except subprocess.TimeoutExpired:  # somebody has stopped it
            self._process.kill()
            self._process.wait()
        os.close(self.pidfd)
