"""The faults of a watched run, for the pages and for the metrics."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launcher.control.fault_texts import is_gone
from launcher.web.batch import Batch
from launcher.web.hub import Hub, Message
from launcher.web.run_client import RunClient

_BATCH_S = 0.2  # several faults change together: what follows from one is found with it

Document = dict[str, Any]  # a fault; docs/reference/faults.md


class FaultFeed:
    """Follows the verb `faults`. `known`: by the names of the faults; None: nothing is watched."""

    def __init__(self, hub: Hub) -> None:
        self.known: dict[str, Document] | None = None
        self._hub = hub
        self._changed: Batch[str] = Batch(_BATCH_S, self._send)  # names of faults

    def start(self, client: RunClient) -> None:
        """Follow them, if the run is watched: else it refuses."""
        self._hub.start(self._begin(client))

    async def _begin(self, client: RunClient) -> None:
        answer = await client.ask("faults")
        if answer.get("ok"):
            self.known = {}
            self._hub.send(self._message((), reset=True))
            client.follow("faults", self.take)

    def take(self, item: Document) -> None:
        """An item of the stream; changes are sent together."""
        if self.known is None or "dropped" in item:
            return  # what comes next has everything of a fault
        name = item["fault"]
        if is_gone(item):
            self.known.pop(name, None)
        else:
            self.known[name] = item
        self._changed.add(name)

    def flush(self) -> None:
        """Send what has changed."""
        self._changed.flush()

    def _send(self, names: list[str]) -> None:
        self._hub.send(self._message(dict.fromkeys(names), reset=False))

    def opening(self) -> list[Message]:
        """What a page gets when it opens."""
        return [] if self.known is None else [self._message(self.known, reset=True)]

    def _message(self, names: Iterable[str], *, reset: bool) -> Message:
        known, names = self.known or {}, list(names)
        return {
            "event": "faults",
            "items": [known[name] for name in names if name in known],
            "gone": [name for name in names if name not in known],
            "reset": reset,
        }
