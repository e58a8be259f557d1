"""Places in launch files, the same on every machine."""

from __future__ import annotations

import os
from typing import Any

THE_FILE = "the launch file"


class Places:
    """Names files relative to the folder of the launch file; others by their name only."""

    def __init__(self, launch_file: str) -> None:
        self._folder = os.path.dirname(os.path.abspath(launch_file)) + os.sep

    def of_entity(self, entity: Any) -> str:
        """`file:line` of an entity of a launch file."""
        origin = getattr(entity, "_origin", None)
        return THE_FILE if origin is None else self.of_text(f"{origin.path}:{origin.line}")

    def of_text(self, place: str) -> str:
        """As `of_entity`, of `path:line`."""
        if place.startswith(self._folder):
            return place[len(self._folder) :]
        return os.path.basename(place) or THE_FILE
