"""The error of the ROS verbs, in the format of ros2cli with our hint below."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.base import text
from launcher.base.errors import LauncherError


class VerbError(LauncherError):
    """Printed without `error: `, like the errors of ros2cli."""

    def render(self) -> str:
        lines = [self.message, *([f"hint: {self.hint}"] if self.hint else [])]
        return text.escape("\n".join(lines))


def name_fault(error: Exception) -> str:
    """What rclpy says about an invalid name, with the name, but without the arrow below it."""
    fault, _, name = str(error).rpartition("\n")[0].partition(":\n")
    return f"{fault}: {name.strip()}"


def did_you_mean(word: str, known: Iterable[str]) -> str | None:
    """`did you mean '/chatter'?` for a similar name in the graph; a missing slash comes first."""
    names, slashed = list(known), f"/{word.lstrip('/')}"
    return f"did you mean '{slashed}'?" if slashed in names else text.did_you_mean(word, names)
