"""What holds for all tests."""

from __future__ import annotations

import signal


def pytest_configure() -> None:
    """Hear SIGINT, and let children hear it, although a shell has started us with `&`."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
