"""Clock: moments on the two clocks of the protocol.

DDS stamps messages in wall time; whoever compares them with anything needs the monotonic clock,
which is the same for all processes of a machine.
"""

from __future__ import annotations

import time

NANOS = 1_000_000_000


def moment() -> dict[str, float]:
    """Now, on both clocks."""
    return {"mono": time.monotonic(), "wall": time.time()}


def wall_offset_ns() -> int:
    """What is added to a monotonic time to make it wall time."""
    return time.time_ns() - time.monotonic_ns()
