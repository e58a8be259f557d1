"""Functions for all helper processes: their start, their last error line, waiting for them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence

from launcher.posix import open_files

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def start_module(words: Sequence[str], **options: object) -> subprocess.Popen[bytes]:
    """`python -m` with these words, in a new session; OSError. `options` are those of Popen.

    It has the limit of open files that the launcher was started with.
    """
    settings: dict[str, Any] = {"start_new_session": True, **options}
    if open_files.is_raised():
        settings["preexec_fn"] = open_files.lower
    return subprocess.Popen([sys.executable, "-m", *words], **settings)


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
