"""The error of bags."""

from __future__ import annotations

from launcher.base.errors import LauncherError


class BagError(LauncherError):
    """A bag cannot be read or written; exit code 1."""
