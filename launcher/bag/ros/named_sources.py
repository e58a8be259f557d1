"""The topics, services and actions that a command line of `bag record` names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from launcher.bag.bag_actions import STATUS_TYPE, action_of, status_topic
from launcher.bag.bag_services import EVENTS
from launcher.base.ros_errors import did_you_mean
from launcher.ros.snapshot.ros_graph import Direction

if TYPE_CHECKING:
    from launcher.bag.ros.recorder import RecorderOptions
    from launcher.ros.discovery.observer import Observer

_YET = {
    "topic": "does not appear to be published yet",
    "service": "does not appear to publish its calls yet",
    "action": "does not appear to be there yet",
}
_AT_THE_END = {
    "topic": "was not published",
    "service": "did not publish its calls",
    "action": "was not there",
}


class NamedSources:
    """What is missing of them; topics with their types are what is recorded, or published."""

    def __init__(self, observer: Observer, options: RecorderOptions) -> None:
        self._observer = observer
        self._selection = options.selection
        self._repeated = options.repeat
        topics = {*options.selection.topics, *options.static}
        self._names = [
            *(("topic", name) for name in sorted(topics)),
            *(("service", name) for name in sorted(options.selection.services)),
            *(("action", name) for name in sorted(options.selection.actions)),
        ]

    def __bool__(self) -> bool:
        return bool(self._names)

    @property
    def kinds(self) -> str:
        """`topic`, or `topic, service or action`."""
        return "topic" if {"topic"}.issuperset(dict(self._names)) else "topic, service or action"

    def missing_yet(self, recorded: Mapping[str, str]) -> Iterator[str]:
        for kind, name in self._missing(recorded):
            yield self._said(kind, name, _YET[kind])

    def missing_at_the_end(self, recorded: Mapping[str, str]) -> Iterator[str]:
        for kind, name in self._missing(recorded):
            yield f"warning: {self._said(kind, name, _AT_THE_END[kind])}"
        for name in self._repeated:
            if name not in recorded:
                yield f"warning: {name} is not repeated, since it was not recorded"

    def _missing(self, recorded: Mapping[str, str]) -> list[tuple[str, str]]:
        known = {kind: set(_named(kind, recorded)) for kind in _YET}
        return [(kind, name) for kind, name in self._names if name not in known[kind]]

    def _said(self, kind: str, name: str, what: str) -> str:
        """The sentence about a name, with the reason or the name that may be meant."""
        shown = name if kind == "topic" else f"{kind} {name}"
        published = self._observer.topic_types()
        if self._is_excluded(kind, name, published):
            return f"{shown} is excluded"
        if kind == "topic" and self._observer.infos(name, Direction.PUBLISHER):
            return f"{shown} is not recorded"  # the reason was said before
        if kind == "service" and name in dict(self._observer.node.get_service_names_and_types()):
            return f"{shown} {what}: its introspection is off"
        near = did_you_mean(name, {*_named(kind, published)} - {name})
        return f"{shown} {what} ({near})" if near else f"{shown} {what}"

    def _is_excluded(self, kind: str, name: str, published: Mapping[str, Iterable[str]]) -> bool:
        if kind == "action":
            return self._selection.excludes(status_topic(name), STATUS_TYPE)
        topic = name + EVENTS if kind == "service" else name
        return any(self._selection.excludes(topic, one) for one in ("", *published.get(topic, ())))


def _named(kind: str, topics: Mapping[str, str | list[str]]) -> Iterator[str]:
    """The names of this kind that topics belong to."""
    for topic, types in topics.items():
        type_name = types if isinstance(types, str) else "".join(types[:1])
        action = action_of(topic, type_name)
        if kind == "action":
            if action is not None:
                yield action
        elif kind == "topic":
            yield topic
        elif topic.endswith(EVENTS):
            yield topic.removesuffix(EVENTS)
