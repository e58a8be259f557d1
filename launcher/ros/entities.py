"""Keeps the memory of long-lived nodes bounded."""

from __future__ import annotations

from typing import Any

_ROOM = 64


class _LivingReferences(set[Any]):
    """Weak references; dead ones are dropped when there are twice as many as before."""

    def __init__(self) -> None:
        super().__init__()
        self._most = _ROOM

    def add(self, reference: Any) -> None:
        if len(self) >= self._most:
            self.difference_update([one for one in list(self) if one() is None])
            self._most = 2 * len(self) + _ROOM
        super().add(reference)


def forget_destroyed(node: Any) -> None:
    """Let its callback group forget entities that were destroyed, which rclpy does not.

    Call it for a node that makes entities again and again; before it makes the first.
    """
    group = node.default_callback_group
    entities, group.entities = group.entities, _LivingReferences()
    group.entities.update(entities)
