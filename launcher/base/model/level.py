"""How severe what a check has found is."""

from __future__ import annotations

import enum


class Level(enum.Enum):
    """Severity of a finding; only a problem makes the exit code 1."""

    OK = "ok"
    NOTE = "note"
    PROBLEM = "problem"
