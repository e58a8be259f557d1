"""How many examples a hypothesis test tries."""

from __future__ import annotations

from hypothesis import settings

FEW = 4


def examples(count: int) -> int:
    """`count` when searching (`make thorough`), else a share of it; the profiles decide."""
    return max(min(count, FEW), count * settings.default.max_examples // 100)
