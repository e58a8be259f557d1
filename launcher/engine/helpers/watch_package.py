"""The Python package that watches files, which need not be installed."""

from __future__ import annotations

from launcher.errors import UsageError


def check_installed() -> None:
    """UsageError if it is missing."""
    from importlib.util import find_spec

    if find_spec("watchfiles") is None:
        from launcher.packages.extras import install_command

        raise UsageError(
            "watching files needs the Python package 'watchfiles', which is not installed",
            hint=install_command("watch"),
        )
