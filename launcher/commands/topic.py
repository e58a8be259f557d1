"""`topic VERB ...`: what is on the topics, without ros2cli and without a daemon."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Sequence

from launcher.errors import ExitCode
from launcher.graph.verb import Parser, add_verb, parser_of, print_json, settled


def main(words: Sequence[str]) -> int:
    """Run one `topic` command; the exit code."""
    parser = build_parser()
    options = parser.parse_args(list(words))
    if options.sub is None:
        parser.print_help()
        return ExitCode.OK
    return _RUN[options.sub](options)


def build_parser() -> Parser:
    """The options of every sub-verb."""
    parser, table = parser_of("topic", "Look at topics.")
    _add_list(table)
    _add_info(table)
    return parser


def _add_list(table: object) -> None:
    sub = add_verb(table, "list", "names of all topics")
    sub.add_argument("-t", "--show-types", action="store_true", help="their types as well")
    sub.add_argument("-v", "--verbose", action="store_true", help="who uses them, by direction")
    sub.add_argument("-c", "--count-topics", action="store_true", help="only how many there are")
    sub.add_argument(
        "--include-hidden-topics", action="store_true", help="those with a part _like_this, too"
    )


def _add_info(table: object) -> None:
    sub = add_verb(table, "info", "type of a topic, its publishers and subscriptions")
    sub.add_argument("topic_name", metavar="NAME", help="full name of the topic")
    sub.add_argument("-v", "--verbose", action="store_true", help="each endpoint with its QoS")
    sub.add_argument(
        "--explain", action="store_true", help="which pairs do not match, why, and what to change"
    )


def _list(options: Namespace) -> int:
    from launcher.graph import topics

    with settled(options) as observer:
        found = topics.listed(observer, hidden=options.include_hidden_topics)
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
        print("\n".join(topics.verbose_listing(found)))
    else:
        for topic in found:
            print(topic.label if options.show_types else topic.name)
    return ExitCode.OK


def _info(options: Namespace) -> int:
    from launcher.graph import topics
    from launcher.graph.matching import explain, mismatches

    name = options.topic_name
    with settled(options) as observer:
        if options.json:
            print_json(topics.info_document(observer, name))
            return ExitCode.OK
        lines = list(topics.info_lines(observer, name, verbose=options.verbose))
        endpoints = observer.endpoints(name)
    print("\n".join(lines))
    if options.explain or (options.verbose and mismatches(endpoints)):
        print(explain(endpoints))
    return ExitCode.OK


_RUN: dict[str, Callable[[Namespace], int]] = {"list": _list, "info": _info}
