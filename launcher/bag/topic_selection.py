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
        if self.excludes(topic, type_name):
            return False
        if topic in self.topics:
            return True
        if (action := action_of(topic, type_name)) is not None:
            name, is_hidden_topic = action, self.hidden and not topic.endswith(EVENTS)
            wanted = self.all_actions or action in self.actions
            wanted = wanted or (self.all_topics and is_hidden_topic)
        elif topic.endswith(EVENTS):
            name = topic.removesuffix(EVENTS)
            wanted = self.all_services or name in self.services
        elif is_hidden(topic) and not self.hidden:
            return False
        else:
            name, wanted = topic, self.all_topics or type_name in self.types
        return wanted or (self.regex is not None and self.regex.search(name) is not None)

    def excludes(self, topic: str, type_name: str) -> bool:
        """Whether a topic is left out, even if it is named."""
        name, excluded = topic, self.exclude_topics
        if (action := action_of(topic, type_name)) is not None:
            name, excluded = action, self.exclude_actions
        elif topic.endswith(EVENTS):
            name, excluded = topic.removesuffix(EVENTS), self.exclude_services
        elif type_name in self.exclude_types:
            return True
        if name in excluded or topic in self.exclude_topics:
            return True
        return self.exclude_regex is not None and self.exclude_regex.search(name) is not None


def expression(word: str) -> re.Pattern[str]:
    """A regular expression of a command line; UsageError."""
    try:
        return re.compile(word)
    except re.error as error:
        raise UsageError(f"'{word}' is not a regular expression: {error}") from None
