"""Top: a table of processes in an order that a person chooses, and the part of it that is seen."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.console.cutting import end_cut
from launcher.console.process_table import process_table
from launcher.console.tables import render
from launcher.console.trouble import is_in_trouble

Process = Mapping[str, Any]

# Key -> the name of an order.
ORDERS = {"c": "cpu", "m": "memory", "n": "name", "r": "restarts", "s": "state"}
KEYS_HINT = f"arrows scroll | sort: {' '.join(ORDERS)}"
HEAD_ROWS = 4  # with fewer, the head of the table gives way to a process
_DIGITS = re.compile(r"(\d+)")


def _by_name(process: Process) -> tuple[Any, ...]:
    """`robot_10` behind `robot_9`."""
    parts = _DIGITS.split(process["name"])
    return tuple(int(part) if place % 2 else part for place, part in enumerate(parts))


_KEYS: dict[str, Callable[[Process], Any]] = {
    "cpu": lambda process: -(process.get("cpu_percent") or 0.0),
    "memory": lambda process: -(process.get("memory_bytes") or 0),
    "name": _by_name,
    "restarts": lambda process: -(process.get("restarts") or 0),
    "state": lambda process: (not is_in_trouble(process), process["state"]),
}


class Top:
    """`press` takes a key, `lines` shows what there is now."""

    def __init__(self, order: str = "cpu") -> None:
        self.order = order
        self._first = 0
        self._page = 1

    def press(self, key: str) -> bool:
        """Scroll or sort; False if the key means nothing here."""
        if key in ORDERS:
            self.order, self._first = ORDERS[key], 0
            return True
        steps = {
            "up": -1,
            "down": 1,
            "pageup": -self._page,
            "pagedown": self._page,
            "home": -self._first,
            "end": 1_000_000,  # as far as there is anything
        }
        self._first = max(0, self._first + steps.get(key, 0))
        return key in steps

    def sorted(self, found: Sequence[Process]) -> list[Process]:
        """In the order that was chosen; equal ones as they were started."""
        return sorted(found, key=_KEYS[self.order])

    def lines(self, found: Sequence[Process], columns: int, rows: int, *, colour: bool) -> str:
        """So many rows at most: a head, processes, and what part of all of them that is."""
        has_place = rows > 1
        has_head = rows >= HEAD_ROWS
        self._page = max(1, rows - has_place - has_head)
        self._first = min(self._first, max(0, len(found) - self._page))
        seen = self.sorted(found)[self._first : self._first + self._page]
        table = render(process_table(seen, columns, has_head=has_head), columns, colour=colour)
        return "\n".join([table, *([end_cut(self._place(found), columns)] if has_place else ())])

    def _place(self, found: Sequence[Process]) -> str:
        count, first = len(found), self._first + 1
        last = min(count, self._first + self._page)
        if count <= self._page:
            return f"{count} by {self.order}"
        seen = f"{first}-{last}" if last > first else str(first)
        more = ((first - 1, "above"), (count - last, "below"))
        return f"{seen} of {count} by {self.order}: " + ", ".join(
            f"{number} more {where}" for number, where in more if number
        )
