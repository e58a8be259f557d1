"""Subscribing: from the name of a topic to a subscription, now or when somebody publishes it."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from launcher.command_line import Parsed
from launcher.graph.domains import why_empty
from launcher.graph.errors import VerbError, did_you_mean
from launcher.graph.listener import (
    Listener,
    Target,
    await_introduction,
    find_target,
    fitted_profile,
    target_in,
    target_now,
)
from launcher.graph.verb import spin_time_s, warn

if TYPE_CHECKING:
    from launcher.graph.observer import Observer

_LOOK_S = 0.1  # endpoints of one participant arrive together, so the next look has them all


def subscribe_now(observer: Observer, listener: Listener, name: str, options: Parsed) -> None:
    """Subscribe; VerbError as ros2cli words it if the type cannot be told."""
    target = _first_target(observer, name, options.message_type, options)
    if target is None:
        print(_unpublished(name), flush=True)
        raise VerbError(
            "Could not determine the type for the passed topic", hint=_hint(observer, name)
        )
    _subscribe(listener, target, options)


class Awaited:
    """Subscribes to topics now, and to those that nobody has yet as soon as somebody does.

    `found` is told of each.
    """

    def __init__(
        self,
        observer: Observer,
        listener: Listener,
        names: Sequence[str],
        options: Parsed,
        found: Callable[[Target], None],
    ) -> None:
        self._observer = observer
        self._listener = listener
        self._options = options
        self._found = found
        self._missing: dict[str, Target | None] = {}
        for name in names:
            if target := _first_target(observer, name, None, options):
                self._take(target)
            else:
                self._miss(name)
        self._next_look = time.monotonic() + _LOOK_S

    def _miss(self, name: str) -> None:
        self._missing[name] = None
        print(_unpublished(name), flush=True)
        if hint := _hint(self._observer, name):
            warn(f"hint: {hint}")

    def _take(self, target: Target) -> None:
        _subscribe(self._listener, target, self._options)
        self._found(target)

    def look(self) -> None:
        """Look for those that are missing, ten times a second; call it as often as you like."""
        if not self._missing or time.monotonic() < self._next_look:
            return
        for name, before in list(self._missing.items()):
            target = self._missing[name] = target_now(self._observer, name)
            if target is not None and target == before:
                del self._missing[name]
                self._take(target)
        self._next_look = time.monotonic() + _LOOK_S


def _first_target(
    observer: Observer, name: str, type_name: str | None, options: Parsed
) -> Target | None:
    """The topic as it is at the start."""
    if (look := observer.seen_ahead()) is not None:
        target = target_in(look, name, type_name)
        if target is not None:
            await_introduction(observer, target)
        return target
    return find_target(observer, name, type_name, spin_time_s(options))


def _hint(observer: Observer, name: str) -> str | None:
    """For a name that nobody has."""
    look = observer.seen_ahead() or observer.look()
    return did_you_mean(name, look.topic_types()) if look.nodes else why_empty(observer.domain_id)


def _unpublished(name: str) -> str:
    return f"WARNING: topic [{name}] does not appear to be published yet"


def _subscribe(listener: Listener, target: Target, options: Parsed) -> None:
    profile, notes = fitted_profile(target, options)
    for note in notes:
        print(note)
    sys.stdout.flush()
    listener.subscribe(target, profile)
