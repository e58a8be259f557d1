"""Which topics are recorded, played or kept."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from launcher.bag.bag_actions import action_of
from launcher.bag.bag_services import EVENTS
from launcher.base.errors import UsageError
from launcher.ros.snapshot.ros_graph import is_hidden


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """By names, types and regular expressions; what is excluded is excluded in any case.

    `services` are names of services, whose calls are in topics `SERVICE/_service_event`, and
    `actions` those of actions, which have five topics each: events of services are among them.
    """

    all_topics: bool = False
    all_services: bool = False
    all_actions: bool = False
    topics: Collection[str] = ()
    services: Collection[str] = ()
    actions: Collection[str] = ()
    types: Collection[str] = ()
    regex: re.Pattern[str] | None = None
    exclude_regex: re.Pattern[str] | None = None
    exclude_topics: Collection[str] = ()
    exclude_services: Collection[str] = ()
    exclude_actions: Collection[str] = ()
    exclude_types: Collection[str] = ()
    hidden: bool = False

    @property
    def is_empty(self) -> bool:
        everything = (self.all_topics, self.all_services, self.all_actions)
        named = (self.topics, self.services, self.actions, self.types)
        return not any(everything) and not any(named) and self.regex is None

    def has(self, topic: str, type_name: str) -> bool:
        """Whether a topic is selected; names are full ones."""
        if (action := action_of(topic, type_name)) is not None:
            is_hidden_topic = self.hidden and self.all_topics and not topic.endswith(EVENTS)
            wanted = self.all_actions or action in self.actions or is_hidden_topic
            return self._has(action, topic, wanted, self.exclude_actions)
        if topic.endswith(EVENTS):
            service = topic.removesuffix(EVENTS)
            wanted = self.all_services or service in self.services
            return self._has(service, topic, wanted, self.exclude_services)
        if topic in self.exclude_topics or type_name in self.exclude_types:
            return False
        if self.exclude_regex is not None and self.exclude_regex.search(topic):
            return False
        if topic in self.topics:
            return True
        if not self.hidden and is_hidden(topic):
            return False
        if self.all_topics or type_name in self.types:
            return True
        return self.regex is not None and self.regex.search(topic) is not None

    def _has(self, name: str, topic: str, wanted: bool, excluded: Collection[str]) -> bool:
        """Whether a topic of a service or an action is selected."""
        if name in excluded or topic in self.exclude_topics:
            return False
        if self.exclude_regex is not None and self.exclude_regex.search(name):
            return False
        if wanted or topic in self.topics:
            return True
        return self.regex is not None and self.regex.search(name) is not None


def expression(word: str) -> re.Pattern[str]:
    """A regular expression of a command line; UsageError."""
    try:
        return re.compile(word)
    except re.error as error:
        raise UsageError(f"'{word}' is not a regular expression: {error}") from None
