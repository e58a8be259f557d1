"""What to say, once, about endpoints that do not match ours."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from launcher.ros.snapshot.qos_matching import Mismatch, explain, mismatches
from launcher.ros.snapshot.ros_graph import Endpoint

_NAMES_S = 2.0  # names of nodes arrive after their endpoints, usually within 0.1 s


class Unmatched:
    """Judges the endpoints of a topic again and again; waits a moment for names of nodes."""

    def __init__(self) -> None:
        self._said: set[str] = set()
        self._since_s: float | None = None

    def news(
        self, known: Sequence[Endpoint], text_of: Callable[[list[Mismatch], str], str]
    ) -> str | None:
        """A text about what does not match; None if there is nothing, or it was returned before.

        `text_of` makes it of the mismatches and their explanation.
        """
        found = mismatches(known)
        if not found:
            return None
        now_s = time.monotonic()
        self._since_s = now_s if self._since_s is None else self._since_s
        ends = [end for one in found for end in (one.subscription, *one.publishers)]
        if not all(end.has_name for end in ends) and now_s - self._since_s < _NAMES_S:
            return None
        text = text_of(found, explain(known))
        if text in self._said:
            return None
        self._said.add(text)
        return text
