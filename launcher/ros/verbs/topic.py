"""`topic VERB ...`: list, inspect, print, measure and publish topics."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.option import (
    JSON_LINES,
    Option,
    count,
    number,
    option,
    positive_seconds,
)
from launcher.base.verb_table import VERBS
from launcher.ros.verb import (
    SIM_TIME,
    GraphAccess,
    dispatch,
    graph_snapshot,
    print_json,
    require_rate,
    ros_command,
    seconds,
    show,
    show_typed,
    standard_input,
)
from launcher.ros.verbs.listening import QOS, STYLE, natural, qos_options, style

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.ros.verbs.measurements import MeasureOptions

_MAX = 2**31 - 1


def _positive(word: str) -> int:
    """A whole number; ValueError with the text of ros2cli."""
    try:
        return count(word, 1, _MAX)
    except ValueError:
        raise ValueError("value must be a positive integer") from None


NAME = option("NAME", name="topic_name")
NAMES = option("[NAME ...]", name="topic_names")
ALL = option("-a, --all", "all topics that there are")
HIDDEN = option("--include-hidden-topics", "hidden topics as well")
COUNT = option("-c, --count-topics", "print only the number of topics")
FOR = option("--for S", "end after S seconds", seconds, name="for_s")


def _window(default: int) -> Option:
    return option("-w, --window N", "number of messages to average over", _positive, default)


def _list(options: Parsed) -> int:
    from launcher.ros.topics import listing

    found = listing.listed(graph_snapshot(options), hidden=options.include_hidden_topics)
    lines: Iterable[object] = (one.label if options.show_types else one.name for one in found)
    if options.count_topics:
        lines = [len(found)]
    elif options.verbose:
        lines = ["\n".join(listing.verbose_listing(found))]
    return show(options, {"topics": [one.document() for one in found]}, lines)


def _info(options: Parsed) -> int:
    from launcher.ros.snapshot.qos_matching import explain, mismatches
    from launcher.ros.topics import listing

    name, graph = full_name(options.topic_name), graph_snapshot(options)
    if options.json:
        print_json(listing.info_document(graph, name))
        return ExitCode.OK
    print("\n".join(listing.info_lines(graph, name, verbose=options.verbose)))
    endpoints = graph.endpoints(name)
    if options.explain or (options.verbose and mismatches(endpoints)):
        print(explain(endpoints))
    return ExitCode.OK


def _type(options: Parsed) -> int:
    from launcher.ros.topics import listing

    name = options.topic_name
    types = listing.known_types(graph_snapshot(options)).get(full_name(name), [])
    if not types:
        from launcher.ros.topics.listener import full_topic

        full_topic(name)  # VerbError if it cannot be one
    show(options, {"name": full_name(name), "types": types}, types)
    return ExitCode.OK if types else ExitCode.PROCESS_FAILED


def _find(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import of_type
    from launcher.ros.snapshot.ros_graph import is_hidden
    from launcher.ros.topics import listing

    hidden = options.include_hidden_topics
    known = listing.known_types(graph_snapshot(options)).items()
    shown = {name: types for name, types in known if hidden or not is_hidden(name)}
    found = of_type(shown, options.topic_type, "msg")
    return show_typed(options, "topics", found, only_count=options.count_topics)


def _echo(options: Parsed) -> int:
    from launcher.base.ros_errors import VerbError
    from launcher.ros.topics.echo import Writer
    from launcher.ros.verbs.streams import EchoOptions, echo

    topics, message_type = _topics_and_type(options.words)
    if options.field and options.raw:
        raise UsageError("--field and --raw exclude each other")
    for path in options.field:
        if not path.strip("."):
            raise VerbError(f"Invalid field value '{path}'")
    writer = Writer(
        style=style(options),
        csv=options.csv,
        json=options.json,
        raw=options.raw,
        info=options.include_message_info,
        fields=options.field,
        prefixed=len(topics) > 1,
    )
    return echo(
        EchoOptions(
            access=GraphAccess.of(options),
            topics=topics,
            type=message_type,
            writer=writer,
            qos=qos_options(options),
            filter=options.filter,
            once=options.once,
            clear=options.clear,
            timeout_s=options.timeout,
            node_name=options.node_name,
        )
    )


def _topics_and_type(words: list[str]) -> tuple[list[str], str | None]:
    """The topics, and the type that may follow a single one; VerbError for what is neither.

    Further topics begin with a slash, a type has one inside.
    """
    strange = [word for word in words[1:] if not word.startswith("/")]
    if len(words) == 2 and strange and "/" in words[1]:
        return words[:1], words[1]
    if strange:
        from launcher.base.ros_errors import VerbError

        kinds = "a further topic (/NAME) nor the type of a single one (PACKAGE/msg/NAME)"
        hint = f"'{strange[0]}' is neither {kinds}"
        raise VerbError("The passed message type is invalid", hint=hint)
    return words, None


def _measuring(
    options: Parsed,
    topics: list[str],
    accepted: str | None = None,
    min_hz: float | None = None,
    *,
    hidden: bool = False,
) -> MeasureOptions:
    from launcher.ros.verbs.measurements import MeasureOptions

    return MeasureOptions(
        access=GraphAccess.of(options),
        topics=topics,
        qos=qos_options(options),
        window=options.window,
        for_s=options.for_s,
        use_sim_time=options.use_sim_time,
        json=options.json,
        filter=accepted,
        min_hz=min_hz,
        hidden=hidden,
    )


def _named_or_all(options: Parsed) -> list[str]:
    """The topics; none for all of them."""
    names: list[str] = options.topic_names or []
    if names and options.all:
        raise UsageError("Cannot specify both --all/-a and topic names")
    if not names and not options.all:
        usage = f"usage: {options.command.usage}"
        raise UsageError("NAME is missing", hint=f"{usage}; --all for all topics")
    return names


def _hz(options: Parsed) -> int:
    from launcher.ros.verbs.measurements import Rates

    if options.min_hz is not None and not math.isfinite(options.min_hz):
        raise UsageError(f"--min takes a rate in Hz, not {options.min_hz}")
    if options.min_hz is not None and options.for_s is None:
        raise UsageError("--min needs --for", hint="for example: --for 5 --min 4.5")
    named, hidden = _named_or_all(options), options.include_hidden_topics
    return Rates(_measuring(options, named, options.filter, options.min_hz, hidden=hidden)).run()


def _bw(options: Parsed) -> int:
    from launcher.ros.verbs.measurements import Bandwidths

    hidden = options.include_hidden_topics
    return Bandwidths(_measuring(options, _named_or_all(options), hidden=hidden)).run()


def _delay(options: Parsed) -> int:
    from launcher.ros.verbs.measurements import Ages

    return Ages(_measuring(options, [options.topic_name])).run()


def _pub(options: Parsed) -> int:
    from launcher.ros.verbs.publish import PublishOptions, publish

    require_rate(options.rate)
    if options.values and (options.stdin or options.yaml_file):
        raise UsageError(
            f"YAML and {'--stdin' if options.stdin else '--yaml-file'} exclude each other"
        )
    limit, wanted = 1 if options.once else options.times, options.wait_matching_subscriptions
    wanted = int(limit is not None) if wanted is None else wanted
    if options.max_wait_time_secs is not None and not wanted:
        raise UsageError(
            "--max-wait-time-secs option is only effective with --wait-matching-subscriptions, "
            "--once or --times"
        )
    return publish(
        PublishOptions(
            access=GraphAccess.of(options),
            topic=options.topic_name,
            type=options.message_type,
            values=standard_input() if options.stdin else options.values,
            yaml_file=options.yaml_file,
            qos=qos_options(options),
            rate_hz=options.rate,
            limit=limit,
            print_each=options.print,
            subscriptions=wanted,
            max_wait_s=options.max_wait_time_secs,
            keep_alive_s=options.keep_alive,
            node_name=options.node_name,
            use_sim_time=options.use_sim_time,
            json=options.json,
        )
    )


COMMAND = Command(
    "topic",
    VERBS["topic"],
    options=(HIDDEN,),
    commands=(
        ros_command(
            "topic list",
            "list topics",
            _list,
            option("-t, --show-types", "show their types"),
            option("-v, --verbose", "group them by direction, with the number of users"),
            COUNT,
            HIDDEN,
        ),
        ros_command(
            "topic info",
            "show the type, the publishers and the subscriptions of a topic",
            _info,
            NAME,
            option("-v, --verbose", "show each endpoint with its QoS"),
            option("--explain", "explain which pairs do not match, and why"),
        ),
        ros_command(
            "topic echo",
            "print the messages of topics",
            _echo,
            option(
                "NAME ...",
                "topics, further ones with their slash; the TYPE of a single one may follow",
                name="words",
            ),
            option("--once", "end after the first message"),
            option("--timeout S", "end after S seconds", seconds),
            option(
                "--field A.B[0]",
                "print only this field; several are printed one after another",
                default=(),
                repeat="all",
            ),
            option("--filter EXPR", "only messages m for which this is true"),
            *STYLE,
            option("--raw", "print the serialized bytes"),
            option("-i, --include-message-info", "print timestamps and sequence numbers"),
            option("--no-lost-messages", "ignored, for compatibility with ros2"),
            option("-c, --clear", "clear the screen before each message"),
            option("-n, --node-name NAME", "name of the node that subscribes"),
            SIM_TIME,
            groups=QOS,
            json=JSON_LINES,
        ),
        ros_command(
            "topic hz",
            "measure the rate of messages",
            _hz,
            NAMES,
            ALL,
            HIDDEN,
            _window(10000),
            option("--filter EXPR", "count only messages m for which it is true"),
            option("--wall-time", "ignored; always on"),
            FOR,
            option("--min HZ", "with --for: exit code 1 below HZ", number, name="min_hz"),
            SIM_TIME,
            groups=QOS,
            exclusive=(("all", "min_hz"),),
            json=JSON_LINES,
        ),
        ros_command(
            "topic bw",
            "measure the bandwidth",
            _bw,
            NAMES,
            ALL,
            HIDDEN,
            _window(100),
            FOR,
            SIM_TIME,
            groups=QOS,
            json=JSON_LINES,
        ),
        ros_command(
            "topic delay",
            "measure the age of messages by their headers",
            _delay,
            NAME,
            _window(10000),
            FOR,
            SIM_TIME,
            groups=QOS,
            json=JSON_LINES,
        ),
        ros_command(
            "topic pub",
            "publish messages",
            _pub,
            NAME,
            option("TYPE", name="message_type"),
            option("[YAML]", '"field: value"', default="", name="values"),
            option("--stdin", "read the YAML from stdin"),
            option("--yaml-file FILE", "publish each document of this file, and end"),
            option("-r, --rate HZ", "rate", number, 1.0),
            option("-p, --print N", "print each Nth", _positive, 1),
            option("-1, --once", "publish one message"),
            option("-t, --times N", "publish N messages", _positive),
            option(
                "-w, --wait-matching-subscriptions N",
                "wait for N subscriptions (default: 1 with --once and --times, otherwise 0)",
                natural,
            ),
            option("--max-wait-time-secs S", "fail if that takes longer", positive_seconds),
            option(
                "--keep-alive S",
                "stay for S seconds after the last message",
                seconds,
                0.1,
            ),
            option("-n, --node-name NAME", "name of the node that publishes"),
            SIM_TIME,
            groups=QOS,
            exclusive=(("once", "times"), ("stdin", "yaml_file")),
            json=JSON_LINES,
        ),
        ros_command("topic type", "print the type of a topic", _type, NAME),
        ros_command(
            "topic find",
            "list the topics of a type",
            _find,
            option("TYPE", name="topic_type"),
            COUNT,
            HIDDEN,
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
