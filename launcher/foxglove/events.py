"""Follows /parameter_events while somebody wants to know of changes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message

from launcher.foxglove.feeds import Feeds
from launcher.foxglove.parameters import changed_by

_TOPIC, _TYPE = "/parameter_events", "rcl_interfaces/msg/ParameterEvent"


class ParameterEvents:
    """`tell` is called in the event loop with what has changed, as clients get it."""

    def __init__(self, feeds: Feeds, tell: Callable[[list[dict[str, Any]]], None]) -> None:
        self._feeds = feeds
        self._tell = tell
        self._loop = asyncio.get_running_loop()

    def follow(self, wanted: bool) -> None:
        """In the thread of the feeds."""
        if wanted:
            self._feeds.subscribe(_TOPIC, _TYPE, self, self._deliver)
        else:
            self._feeds.unsubscribe(_TOPIC, self)

    def _deliver(self, time_ns: int, payload: bytes) -> None:
        changed = changed_by(deserialize_message(payload, ParameterEvent))
        if changed and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._tell, changed)
