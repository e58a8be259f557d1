"""Which topics are recorded, played or kept."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from launcher.bag.bag_services import EVENTS
from launcher.base.errors import UsageError
from launcher.ros.snapshot.ros_graph import is_hidden


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """By names, types and regular expressions; what is excluded is excluded in any case.

    `services` are names of services, whose calls are in topics `SERVICE/_service_event`.
    """

    all_topics: bool = False
    all_services: bool = False
    topics: Collection[str] = ()
    services: Collection[str] = ()
    types: Collection[str] = ()
    regex: re.Pattern[str] | None = None
    exclude_regex: re.Pattern[str] | None = None
    exclude_topics: Collection[str] = ()
    exclude_services: Collection[str] = ()
    exclude_types: Collection[str] = ()
    hidden: bool = False

    @property
    def is_empty(self) -> bool:
        chosen = (self.all_topics, self.all_services, self.topics, self.services, self.types)
        return not any(chosen) and self.regex is None

    def has(self, topic: str, type_name: str) -> bool:
        """Whether a topic is selected; names are full ones."""
        if topic.endswith(EVENTS):
            return self._has_service(topic.removesuffix(EVENTS), topic)
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

    def _has_service(self, service: str, topic: str) -> bool:
        if service in self.exclude_services:
            return False
        if self.exclude_regex is not None and self.exclude_regex.search(service):
            return False
        if self.all_services or service in self.services or topic in self.topics:
            return True
        return self.regex is not None and self.regex.search(service) is not None


def expression(word: str) -> re.Pattern[str]:
    """A regular expression of a command line; UsageError."""
    try:
        return re.compile(word)
    except re.error as error:
        raise UsageError(f"'{word}' is not a regular expression: {error}") from None
