"""How many processors an injection may keep busy.

More busy processes than this for each processor do not make its load higher than full; they only
keep everything else from its turn, also what would end them.
"""

from __future__ import annotations

import os

MOST_PER_CORE = 16


def usable() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0))


def excess(cores: int, available: int) -> str:
    """Why so many busy processes are refused on `available` processors; empty if they are not."""
    most = MOST_PER_CORE * available
    if cores <= most:
        return ""
    return f"{cores} are more than {most}, {MOST_PER_CORE} for each processor that may be used"
