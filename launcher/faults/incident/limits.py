"""How much of an incident its page shows, so that the file stays small."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PageLimits:
    """Each limit of a part is multiplied by `factor`, from 0 to 1."""

    factor: float = 1.0

    def of(self, most: int) -> int:
        return max(1, round(most * self.factor))


def clipped(text: str, most: int) -> str:
    """The text, of a longer one the beginning and how much more there is."""
    more = len(text) - most
    return text if more <= 0 else f"{text[:most]}… ({more} more characters)"
