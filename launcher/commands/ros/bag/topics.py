"""The options that select topics, of `bag record` and the verbs that read bags."""

from __future__ import annotations

from launcher.bag.selection import Selection, expression, full_name
from launcher.command_line import Parsed, option

EXCLUDE = (
    option("-x, --exclude-regex REGEX", "not those whose names it matches", expression),
    option("--exclude-topics NAME ...", "not these topics"),
)
SELECT = (
    option("--topics NAME ...", "only these topics"),
    option("-e, --regex REGEX", "topics whose names it matches", expression),
    *EXCLUDE,
)


def names(words: object) -> frozenset[str]:
    """The full names that an option has; none if it was not given."""
    return frozenset(map(full_name, words)) if isinstance(words, list) else frozenset()


def selected(options: Parsed) -> Selection:
    """What the options of `SELECT` select; everything without any of them."""
    topics = names(options.topics)
    return Selection(
        all_topics=not topics and options.regex is None,
        all_services=not topics and options.regex is None,
        topics=topics,
        regex=options.regex,
        exclude_regex=options.exclude_regex,
        exclude_topics=names(options.exclude_topics),
        hidden=True,
    )
