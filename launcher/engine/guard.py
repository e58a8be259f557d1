"""Guard: our end of the watchdog. As long as it is open, a killed launcher leaves nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from launcher.engine.watchdog import GOODBYE


class Guard:
    """Starts the watchdog for a run; `close()` says goodbye to it and waits for its end."""

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
        self._process.wait()
