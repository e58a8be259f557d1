"""Event: something that happened; event handlers react to it."""

from __future__ import annotations

from launcher.language.naming import public


@public("launch.event")
class Event:
    """Base of all events; `name` identifies the kind."""

    name = "launch.Event"
