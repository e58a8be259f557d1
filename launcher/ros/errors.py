"""Errors of the ROS verbs: the texts that ros2cli prints, with our hint below."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from launcher.errors import LauncherError, printable


class VerbError(LauncherError):
    """A request that cannot be met; printed without a prefix, as ros2cli prints it."""

    def render(self) -> str:
        """The sentence, and the hint on a line of its own."""
        return printable("\n".join([self.message, *([f"hint: {self.hint}"] if self.hint else [])]))


def did_you_mean(word: str, known: Iterable[str]) -> str | None:
    """`did you mean 'x'?` for the nearest known word; None if nothing is near."""
    candidates = list(known)
    slashed = "/" + word.lstrip("/")
    near = [slashed] if slashed in candidates else difflib.get_close_matches(word, candidates, n=1)
    return f"did you mean '{near[0]}'?" if near else None
