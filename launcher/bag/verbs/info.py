"""`bag info`: what bags have."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from typing import TYPE_CHECKING

from launcher.bag.verbs.files import STORAGES
from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, JSON, option
from launcher.posix.stdio import can_print
from launcher.ros.verb import print_json, warn

if TYPE_CHECKING:
    from launcher.bag.reader import Bag

_STORAGE = option(
    "-s, --storage ID",
    "ignored, for compatibility with ros2: the files show their format",
    choices=STORAGES,
)
_SORTS = ("name", "type", "count")


def _info(options: Parsed) -> int:
    from launcher.bag import info
    from launcher.bag.topic_course import BLOCKS

    if options.verbose:  # reads all messages
        from launcher.posix.allocator import keep_freed_memory

        keep_freed_memory()
    width = shutil.get_terminal_size().columns
    found = [
        info.read(
            path,
            sort=options.sort,
            rates=not (options.no_rates or options.topic_name),
            verbose=options.verbose and not options.topic_name,
            width=None if options.json else width,
        )
        for path in options.bags
    ]
    for one in found:
        warn_of(one.bag)
    if options.json:
        print_json({"bags": [info.document(one) for one in found]})
        return ExitCode.OK
    for one in found:
        if options.topic_name:
            lines: Iterable[str] = [topic.name for topic in one.plain_topics]
            if one.topics and not lines:
                warn(f"{one.bag.path}: it has only topics of services and actions")
        else:
            lines = info.lines(one, width, ascii_only=not can_print(BLOCKS))
        for line in lines:
            print(line)
    return ExitCode.OK


def warn_of(bag: Bag) -> None:
    """What is unusual about a bag, on stderr."""
    for note in bag.notes:
        warn(f"{bag.path}: {note}")


COMMAND = Command(
    "bag info",
    "print what bags have: times, topics, rates",
    about="Print files, times and topics of bags, and below them the rate of each topic over time; "
    "a space is a time without messages.",
    arguments=(option("BAG ...", "folders, or .mcap and .db3 files", name="bags"),),
    options=(
        option("-t, --topic-name", "only names of topics"),
        option("-v, --verbose", "QoS, size of each topic, and calls of services"),
        option("--sort KEY", "order of topics", choices=_SORTS, default="name"),
        option("--no-rates", "no rates over time"),
        _STORAGE,
        JSON,
        DEBUG,
    ),
    abbreviations=True,
    run=_info,
)
