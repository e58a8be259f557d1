"""`topic VERB ...`: what is on the topics, without ros2cli and without a daemon."""

from __future__ import annotations

import argparse
import math
from argparse import Namespace
from collections.abc import Callable, Sequence
from typing import Any

from launcher.errors import ExitCode, UsageError
from launcher.ros.topics.qos import add_qos_options
from launcher.ros.verb import (
    Parser,
    add_verb,
    dispatch,
    parser_of,
    print_json,
    require_rate,
    seconds,
)

_MOST = 2**31 - 1


def main(words: Sequence[str]) -> int:
    """Run one `topic` command; the exit code."""
    return dispatch(build_parser(), _RUN, words)


def build_parser() -> Parser:
    """The options of every sub-verb."""
    parser, table = parser_of("topic", "Look at topics.")
    for add in (_add_list, _add_info, _add_echo, _add_hz, _add_bw, _add_delay, _add_pub):
        add(table)
    sub = add_verb(table, "type", "type of a topic")
    sub.add_argument("topic_name", metavar="NAME")
    sub = add_verb(table, "find", "topics of a type")
    sub.add_argument("topic_type", metavar="TYPE")
    sub.add_argument("-c", "--count-topics", action="store_true", help="only how many there are")
    sub.add_argument("--include-hidden-topics", action="store_true", help="hidden ones, too")
    return parser


def _add_list(table: Any) -> None:
    sub = add_verb(table, "list", "names of all topics")
    sub.add_argument("-t", "--show-types", action="store_true", help="their types as well")
    sub.add_argument("-v", "--verbose", action="store_true", help="who uses them, by direction")
    sub.add_argument("-c", "--count-topics", action="store_true", help="only how many there are")
    sub.add_argument(
        "--include-hidden-topics", action="store_true", help="those with a part _like_this, too"
    )


def _add_info(table: Any) -> None:
    sub = add_verb(table, "info", "type of a topic, its publishers and subscriptions")
    sub.add_argument("topic_name", metavar="NAME", help="full name of the topic")
    sub.add_argument("-v", "--verbose", action="store_true", help="each endpoint with its QoS")
    sub.add_argument(
        "--explain", action="store_true", help="which pairs do not match, why, and what to change"
    )


def _add_echo(table: Any) -> None:
    sub = add_verb(table, "echo", "print the messages of topics")
    sub.add_argument(
        "words", nargs="+", metavar="NAME", help="topics; after a single one its TYPE may follow"
    )
    sub.add_argument("--once", action="store_true", help="end after the first message")
    sub.add_argument("--timeout", type=seconds, metavar="S", help="end after S s of silence")
    sub.add_argument("--field", metavar="A.B[0]", help="only this field")
    sub.add_argument(
        "--filter", metavar="EXPR", help="only messages (or fields) m for which this is true"
    )
    sub.add_argument("--csv", action="store_true", help="values separated by commas")
    sub.add_argument("-f", "--full-length", action="store_true", help="cut nothing")
    sub.add_argument(
        "-l", "--truncate-length", type=_count, default=128, metavar="N", help="cut after N (128)"
    )
    sub.add_argument("--no-arr", action="store_true", help="sizes in place of arrays")
    sub.add_argument("--no-str", action="store_true", help="lengths in place of strings")
    sub.add_argument("--flow-style", action="store_true", help="each message on one line")
    sub.add_argument("--raw", action="store_true", help="bytes as they come")
    sub.add_argument(
        "-i", "--include-message-info", action="store_true", help="times and numbers before each"
    )
    sub.add_argument("--no-lost-messages", action="store_true", help="accepted, without effect")
    add_qos_options(sub)


def _add_hz(table: Any) -> None:
    sub = add_verb(table, "hz", "how often messages arrive")
    sub.add_argument("topic_names", nargs="+", metavar="NAME")
    _add_window(sub, 10000)
    sub.add_argument("--filter", metavar="EXPR", help="count only messages m for which it is true")
    sub.add_argument("--wall-time", action="store_true", help="accepted: it always is")
    sub.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds")
    sub.add_argument(
        "--min", dest="min_hz", type=float, metavar="HZ", help="with --for: exit 1 below this rate"
    )
    add_qos_options(sub)


def _add_bw(table: Any) -> None:
    sub = add_verb(table, "bw", "how many bytes arrive")
    sub.add_argument("topic_name", metavar="NAME")
    _add_window(sub, 100)
    sub.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds")
    add_qos_options(sub)


def _add_delay(table: Any) -> None:
    sub = add_verb(table, "delay", "how old messages are, by the stamps in their headers")
    sub.add_argument("topic_name", metavar="NAME")
    _add_window(sub, 10000)
    sub.add_argument("--for", dest="for_s", type=seconds, metavar="S", help="end after S seconds")
    add_qos_options(sub)


def _add_window(sub: Parser, default: int) -> None:
    sub.add_argument(
        "-w", "--window", type=_positive, default=default, metavar="N", help=f"messages ({default})"
    )


def _add_pub(table: Any) -> None:
    sub = add_verb(table, "pub", "publish messages")
    sub.add_argument("topic_name", metavar="NAME")
    sub.add_argument("message_type", metavar="TYPE")
    sub.add_argument("values", nargs="?", default="", metavar="YAML", help='"field: value"')
    sub.add_argument("--stdin", action="store_true", help="read the YAML from stdin")
    sub.add_argument("-r", "--rate", type=float, default=1.0, metavar="HZ", help="(1)")
    sub.add_argument("-p", "--print", type=_positive, default=1, metavar="N", help="say each Nth")
    times = sub.add_mutually_exclusive_group()
    times.add_argument("-1", "--once", action="store_true", help="one message")
    times.add_argument("-t", "--times", type=_positive, metavar="N", help="N messages")
    sub.add_argument(
        "-w",
        "--wait-matching-subscriptions",
        type=_count,
        metavar="N",
        help="wait for N subscriptions (1 with --once and --times, otherwise 0)",
    )
    sub.add_argument(
        "--keep-alive", type=seconds, default=0.1, metavar="S", help="stay after the last (0.1)"
    )
    add_qos_options(sub)


def _positive(word: str) -> int:
    value = int(word) if word.isdecimal() else 0
    if not 1 <= value <= _MOST:
        raise argparse.ArgumentTypeError("value must be a positive integer")
    return value


def _count(word: str) -> int:
    if not word.isdecimal() or int(word) > _MOST:
        raise argparse.ArgumentTypeError("value must be non-negative integer")
    return int(word)


def _list(options: Namespace) -> int:
    from launcher.ros.topics import listing
    from launcher.ros.verb import graph_snapshot

    found = listing.listed(graph_snapshot(options), hidden=options.include_hidden_topics)
    if options.json:
        print_json(
            [
                {
                    "name": topic.name,
                    "types": list(topic.types),
                    "publishers": topic.publishers,
                    "subscriptions": topic.subscriptions,
                }
                for topic in found
            ]
        )
    elif options.count_topics:
        print(len(found))
    elif options.verbose:
        print("\n".join(listing.verbose_listing(found)))
    else:
        for topic in found:
            print(topic.label if options.show_types else topic.name)
    return ExitCode.OK


def _info(options: Namespace) -> int:
    from launcher.ros.snapshot.qos_matching import explain, mismatches
    from launcher.ros.topics import listing
    from launcher.ros.verb import graph_snapshot

    name, look = options.topic_name, graph_snapshot(options)
    if options.json:
        print_json(listing.info_document(look, name))
        return ExitCode.OK
    print("\n".join(listing.info_lines(look, name, verbose=options.verbose)))
    endpoints = look.endpoints(name)
    if options.explain or (options.verbose and mismatches(endpoints)):
        print(explain(endpoints))
    return ExitCode.OK


def _type(options: Namespace) -> int:
    from launcher.ros.topics import listing
    from launcher.ros.verb import graph_snapshot

    name = options.topic_name
    types = listing.types_or_none(graph_snapshot(options), f"/{name.removeprefix('/')}")
    if not types:
        from launcher.ros.topics.listener import full_topic

        full_topic(name)  # VerbError if it cannot be one
    if options.json:
        print_json({"name": options.topic_name, "types": types})
    else:
        for type_name in types:
            print(type_name)
    return ExitCode.OK if types else ExitCode.PROCESS_FAILED


def _find(options: Namespace) -> int:
    from launcher.ros.messages.interfaces import full_type, warn_if_unknown
    from launcher.ros.topics import listing
    from launcher.ros.verb import graph_snapshot

    hidden, kind = options.include_hidden_topics, full_type(options.topic_type)
    found = listing.of_type(graph_snapshot(options), kind, hidden=hidden)
    if not found:
        warn_if_unknown(kind)
    if options.json:
        print_json(found)
    else:
        for line in [len(found)] if options.count_topics else found:
            print(line)
    return ExitCode.OK


def _echo(options: Namespace) -> int:
    from launcher.ros.topics.streams import echo

    options.topic_names, options.message_type = _topics_and_type(options.words)
    if options.field and options.raw:
        raise UsageError("--field and --raw exclude each other")
    return echo(options)


def _topics_and_type(words: list[str]) -> tuple[list[str], str | None]:
    """The topics and, behind a single topic, its type: the word with a slash inside only."""
    if len(words) == 2 and "/" in words[1] and not words[1].startswith("/"):
        return words[:1], words[1]
    return words, None


def _hz(options: Namespace) -> int:
    from launcher.ros.topics.streams import hz

    if options.min_hz is not None and not math.isfinite(options.min_hz):
        raise UsageError(f"--min takes a rate in Hz, not {options.min_hz}")
    if options.min_hz is not None and options.for_s is None:
        raise UsageError("--min needs --for", hint="for example: --for 5 --min 4.5")
    return hz(options)


def _bw(options: Namespace) -> int:
    from launcher.ros.topics.streams import bw

    return bw(options)


def _delay(options: Namespace) -> int:
    from launcher.ros.topics.streams import delay

    return delay(options)


def _pub(options: Namespace) -> int:
    from launcher.ros.topics.publish import publish

    require_rate(options.rate)
    return publish(options)


_RUN: dict[str, Callable[[Namespace], int]] = {
    "list": _list,
    "info": _info,
    "echo": _echo,
    "hz": _hz,
    "bw": _bw,
    "delay": _delay,
    "pub": _pub,
    "type": _type,
    "find": _find,
}
