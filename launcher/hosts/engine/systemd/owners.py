"""Whose output it is that comes without the name of a unit."""

from __future__ import annotations

from collections import deque

GENERATIONS = 2  # the output of a process may come when it has been started again


class Owners:
    """Processes by the pids and the streams of their last starts; older ones are forgotten."""

    def __init__(self) -> None:
        self._owners: dict[int | str, int] = {}
        self._starts: dict[int, deque[set[int | str]]] = {}

    def __len__(self) -> int:
        return len(self._owners)

    def get(self, key: int | str) -> int | None:
        return self._owners.get(key)

    def started(self, process_id: int, pid: int) -> None:
        if self._owners.get(pid) == process_id:
            return  # it is told twice
        starts = self._starts.setdefault(process_id, deque())
        starts.append(set())
        if len(starts) > GENERATIONS:
            for key in starts.popleft().difference(*starts):
                if self._owners.get(key) == process_id:
                    del self._owners[key]
        self.add(pid, process_id)

    def add(self, key: int | str, process_id: int) -> None:
        """A pid or a stream is of this process."""
        self._owners[key] = process_id
        starts = self._starts.setdefault(process_id, deque([set()]))
        starts[-1].add(key)
