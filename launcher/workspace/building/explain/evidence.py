"""The output of a package's tools: from its log, or by running setup.py again."""

from __future__ import annotations

import os
import subprocess
import sys

_LOG = "stdout_stderr.log"
_COLCON_LOG = "logger_all.log"
_MAX = 4 * 1024 * 1024  # bytes of a log; the first errors are the causes
_TIMEOUT_S = 60


def log_of(folder: str) -> str:
    """The log file with all output of a package, in colcon's folder for it.

    That of colcon itself if no tool was started for the package.
    """
    path = os.path.join(folder, _LOG)
    return path if os.path.exists(path) else os.path.join(os.path.dirname(folder), _COLCON_LOG)


def output_of(folder: str, log: str, stderr: str) -> str:
    """The output of the failed build of the package in `folder`.

    colcon runs setup.py for the metadata of a package, and drops what it writes.
    """
    text = _read(os.path.join(log, _LOG)) or stderr
    if "_get_setup_information" in text and "CalledProcessError" in text:
        return _of_setup(folder) or text
    return text


def _read(path: str) -> str:
    try:
        with open(path, "rb") as file:
            return file.read(_MAX).decode(errors="replace")
    except OSError:
        return ""


def _of_setup(folder: str) -> str:
    """What setup.py writes when it fails."""
    try:
        result = subprocess.run(
            [sys.executable, "setup.py", "--name"],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=_TIMEOUT_S,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return result.stdout.decode(errors="replace") if result.returncode else ""
