"""What is planned of a launch file, which may contain any code: a process of its own plans it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from launcher.base import strict_json

PLAN_S = 20.0  # a launch file that takes longer is launched without


def planned(module: str, words: Sequence[str]) -> Any:
    """What `python -m module words` prints as JSON; None if it prints nothing or takes too long."""
    with subprocess.Popen(
        [sys.executable, "-m", module, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            return strict_json.unpacked(process.communicate(timeout=PLAN_S)[0])
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # its pid is valid until it is waited for
            return None
        except ValueError:
            return None
