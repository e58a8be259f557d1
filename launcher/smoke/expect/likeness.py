"""A bag as an expectation: topics, types, rates and gaps of a run are like those of a recording."""

from __future__ import annotations

import fnmatch
import functools
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from launcher.base.document.fields import FieldError, FieldType, record, shown, text
from launcher.base.document.quantities import PERCENT
from launcher.smoke.expect.expectation_fields import name

if TYPE_CHECKING:
    from launcher.bag.comparing.topic_traits import Traits
    from launcher.bag.reader import Bag

RATES_PERCENT, GAPS_PERCENT = 20.0, 100.0
# Of every node, or of tools: they say little about a system, unless they are named.
_USUAL = ("/rosout", "/parameter_events")


# No slots: the cached properties need a place.
@dataclass(frozen=True, kw_only=True)
class Likeness:
    """`bag` is as written in the file in `folder`; topics may be patterns.

    A rate may differ by `rates_percent`, the longest gap be longer by `gaps_percent`.
    """

    bag: str
    folder: str = ""
    rates_percent: float = RATES_PERCENT
    gaps_percent: float = GAPS_PERCENT
    topics: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.bag

    def beside(self, file: str) -> Likeness:
        """With a path that is relative to a file."""
        return replace(self, folder=os.path.dirname(file))

    @functools.cached_property
    def _good(self) -> Bag:
        from launcher.bag.reader import Bag

        return Bag(os.path.join(self.folder, os.path.expanduser(self.bag)))

    @functools.cached_property
    def reference(self) -> Mapping[str, Traits]:
        """The selected topics of the bag. BagError if it cannot be read; it is read once."""
        return traits_of_bag(self._good, filter(self._selects, self.known))

    @property
    def known(self) -> tuple[str, ...]:
        """All topics of the bag; BagError."""
        return tuple(topic.name for topic in self._good.topics)

    @property
    def duration_s(self) -> float:
        """BagError."""
        return self._good.extent.duration_ns / 1e9

    def _selects(self, topic: str) -> bool:
        if any(fnmatch.fnmatchcase(topic, pattern) for pattern in self.exclude):
            return False
        if self.topics:
            return any(fnmatch.fnmatchcase(topic, pattern) for pattern in self.topics)
        return topic not in _USUAL and not any(part.startswith("_") for part in topic.split("/"))

    def unknown(self) -> tuple[str, ...]:
        """The names and patterns in `topics` that no topic of the bag has; BagError."""
        return tuple(one for one in self.topics if not fnmatch.filter(self.known, one))


def traits_of_bag(bag: Bag, names: Iterable[str]) -> dict[str, Traits]:
    """BagError."""
    from launcher.bag.comparing.topic_traits import traits_of
    from launcher.bag.topic_course import TopicTimes, measured

    times = measured(bag.times())
    wanted = frozenset(names)
    return {
        topic.name: traits_of(topic, times.get(topic.name) or TopicTimes())
        for topic in bag.topics
        if topic.name in wanted
    }


_PATH = text("bag")
_TOPIC = name("topic", wildcards=True)


def _topics(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value:
        raise FieldError(f"{shown(value)} is not a list of topics")
    return tuple(_TOPIC.parse(one) for one in value)


_TOPICS = FieldType(_topics, {"type": "array", "items": _TOPIC.schema, "minItems": 1})
_WHOLE = record("'like'", bag=_PATH, rates=PERCENT, gaps=PERCENT, topics=_TOPICS, exclude=_TOPICS)


def _likeness(value: object) -> Likeness:
    if isinstance(value, str):
        return Likeness(bag=_PATH.parse(value))
    if not isinstance(value, Mapping):
        raise FieldError(
            f"{shown(value)} is not a bag", hint="as in 'like: good.mcap' or {bag: good.mcap}"
        )
    values = _WHOLE.parse(value)
    if "bag" not in values:
        raise FieldError("'bag' is missing", hint="as in {bag: good.mcap, rates: 20 %}")
    return Likeness(
        bag=values["bag"],
        rates_percent=values.get("rates", RATES_PERCENT),
        gaps_percent=values.get("gaps", GAPS_PERCENT),
        topics=values.get("topics", ()),
        exclude=values.get("exclude", ()),
    )


LIKENESS = FieldType(_likeness, {"anyOf": [_PATH.schema, {**_WHOLE.schema, "required": ["bag"]}]})
