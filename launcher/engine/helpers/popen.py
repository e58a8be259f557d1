"""Functions for all helper processes: their last error line, and waiting with a timeout."""

from __future__ import annotations

import os
import subprocess


def last_line(errors: int) -> str:
    """The last line in the file with this descriptor; empty if there is none."""
    size = os.fstat(errors).st_size
    text = os.pread(errors, 1000, max(0, size - 1000)).decode(errors="replace")
    return text.strip().rpartition("\n")[2].strip()


def wait_or_kill(process: subprocess.Popen[bytes], timeout_s: float) -> int | None:
    """Wait for the return code; None if it had to be killed at the timeout."""
    try:
        return process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return None
