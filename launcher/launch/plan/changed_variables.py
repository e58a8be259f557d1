"""What the environment of a process has beside that of the command."""

from __future__ import annotations

from collections.abc import Mapping


def changed_variables(env: Mapping[str, str], before: Mapping[str, str]) -> dict[str, str]:
    """The variables that are new or different, apart from what the launcher itself has added."""
    changed = {name: value for name, value in env.items() if before.get(name) != value}
    path = changed.get("AMENT_PREFIX_PATH")
    if path is not None:
        from launcher.packages.overlay import without_overlays  # few launch files change it

        if without_overlays(path) == before.get("AMENT_PREFIX_PATH", ""):
            del changed["AMENT_PREFIX_PATH"]
    return changed
