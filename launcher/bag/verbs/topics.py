"""The options that select topics, of `bag record` and the verbs that read bags."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

from launcher.bag.bag_actions import source_of
from launcher.bag.topic_selection import Selection, expression
from launcher.base.command_line import Parsed
from launcher.base.model.ros_names import full_name
from launcher.base.option import option
from launcher.base.text import did_you_mean
from launcher.ros.verb import warn

if TYPE_CHECKING:
    from launcher.bag.bag_model import Topic

EXCLUDE = (
    option("-x, --exclude, --exclude-regex REGEX", "not those whose names it matches", expression),
    option("--exclude-topics NAME ...", "not these topics"),
)
SELECT = (
    option("--topics NAME ...", "only these topics"),
    option("-e, --regex REGEX", "topics whose names it matches", expression),
    *EXCLUDE,
)
CALLS = (
    option("--services NAME ...", "events of these services"),
    option("--exclude-services NAME ...", "not events of these services"),
    option("--actions NAME ...", "topics of these actions"),
    option("--exclude-actions NAME ...", "not those of these actions"),
)


def remapping(word: str) -> tuple[str, str]:
    """The full names of `OLD:=NEW`; ValueError."""
    old, sign, new = word.partition(":=")
    if not (old and sign and new):
        raise ValueError(f"'{word}' is not OLD:=NEW")
    return full_name(old), full_name(new)


def names(words: object) -> frozenset[str]:
    """The full names that an option has; none if it was not given."""
    return frozenset(map(full_name, words)) if isinstance(words, list) else frozenset()


_NAMING = ("topics", "services", "actions")


def warn_of_excluded(options: Parsed, topics: Iterable[Topic]) -> None:
    """Name what is excluded, and bags do not have."""
    _warn_of_unknown(options, topics, [f"exclude_{kind}" for kind in _NAMING])


def warn_of_unknown(options: Parsed, topics: Iterable[Topic]) -> None:
    """Name what is selected, excluded or renamed, and bags do not have."""
    kinds = [*_NAMING, *(f"exclude_{kind}" for kind in _NAMING)]
    _warn_of_unknown(options, topics, kinds, [old for old, _ in options.remap or ()])


def _warn_of_unknown(
    options: Parsed, topics: Iterable[Topic], kinds: Iterable[str], more: Iterable[str] = ()
) -> None:
    known = {name for one in topics for name in (one.name, source_of(one.name, one.type))}
    given = {name for kind in kinds for name in names(getattr(options, kind, None))}
    for name in sorted(given.union(more) - known):
        near = did_you_mean(name, known)
        warn(f"warning: {name} is not in what is read" + (f" ({near})" if near else ""))


def selected(options: Parsed, *, without: Collection[str] = ()) -> Selection:
    """What the options of `SELECT` and `CALLS` select; everything if nothing is named.

    And not the topics `without`.
    """
    topics, services, actions = (
        names(getattr(options, kind, None)) for kind in ("topics", "services", "actions")
    )
    everything = not (topics or services or actions) and options.regex is None
    return Selection(
        all_topics=everything,
        all_services=everything,
        all_actions=everything,
        topics=topics,
        services=services,
        actions=actions,
        regex=options.regex,
        exclude_regex=options.exclude_regex,
        exclude_topics=names(options.exclude_topics).union(without),
        exclude_services=names(getattr(options, "exclude_services", None)),
        exclude_actions=names(getattr(options, "exclude_actions", None)),
        hidden=True,
    )
