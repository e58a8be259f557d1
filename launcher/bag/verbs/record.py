"""`bag record`: the options of recording."""

from __future__ import annotations

import itertools
import re
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING

from launcher.bag.topic_selection import Selection, expression
from launcher.bag.verbs.files import COMPRESSION, MAX, SPLIT, byte_count, ignored, storage_of
from launcher.bag.verbs.topics import EXCLUDE, names
from launcher.base.command_line import Parsed
from launcher.base.errors import UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.option import count, number, option, positive_seconds
from launcher.ros.verb import GraphAccess, ros_command, warn

if TYPE_CHECKING:
    from launcher.bag.ros.recorder import RecorderOptions

_UINT32 = 2**32 - 1
_CACHE_BYTES = 100 * 1024 * 1024


def _pair(word: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    if not name or not equals:
        raise ValueError(f"'{word}' is not NAME=VALUE")
    return name, value


def _depth(word: str) -> int:
    return count(word, 1, MAX)


def _repeated(word: str) -> tuple[str, int]:
    """The topic and the number of `TOPIC[=DEPTH]`; ValueError."""
    topic, sign, depth = word.partition("=")
    if not topic:
        raise ValueError(f"'{word}' is not TOPIC or TOPIC=DEPTH")
    return full_name(topic), _depth(depth) if sign else 1


def _node_name(word: str) -> str:
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", word):
        raise ValueError(f"'{word}' is no name of a node")
    return word


def _events_rate(word: str) -> float:
    value = number(word)
    if not 0 <= value <= 1000:
        raise ValueError(f"'{word}' is not a number from 0 to 1000")
    return value


def _record(options: Parsed) -> int:
    from launcher.packages.absent_ros import require

    require("bag record", {"bag": "mcap"})
    from launcher.bag.ros.record_run import RecordOptions, record

    _check_limits(options)
    recorder_options = _recorder_options(options)
    return record(
        GraphAccess.of(options),
        RecordOptions(
            folder=options.output or time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S"),
            storage=storage_of(options),
            cache_bytes=options.max_cache_size or MAX,
            cache_s=options.max_cache_duration,
            start_paused=options.start_paused,
            snapshot=options.snapshot_mode,
            keyboard=not options.disable_keyboard_controls,
            for_s=options.for_s,
            custom_data=dict(itertools.chain(*options.custom_data or ())),
            node_name=options.node_name,
            lost_period_s=1 / rate if (rate := options.stats_max_publishing_rate) else None,
        ),
        recorder_options,
    )


def _recorder_options(options: Parsed) -> RecorderOptions:
    from launcher.bag.ros.bag_qos import read_overrides
    from launcher.bag.ros.recorder import RecorderOptions

    selection = _selection(options)
    path, qos_path = options.static_topics_path, options.qos_profile_overrides_path
    static = {} if path is None else _static(path, selection)
    repeat = dict(options.repeat_transient_local or ())
    if selection.is_empty and not static:
        raise UsageError(
            "nothing to record was named", hint="-a records all topics; or name topics, or --regex"
        )
    _check_names((*selection.topics, *selection.services, *selection.actions, *static, *repeat))
    return RecorderOptions(
        selection=selection,
        overrides={} if qos_path is None else read_overrides(qos_path),
        poll_s=None if options.no_discovery else options.polling_interval / 1000,
        use_sim_time=options.use_sim_time,
        include_unpublished=options.include_unpublished_topics,
        ignore_leaves=options.ignore_leaf_topics,
        static=static,
        repeat=repeat,
        repeat_latched=options.repeat_all_transient_local,
    )


def _static(path: str, selection: Selection) -> dict[str, str]:
    """The topics of a file with their types, without those that are excluded; UsageError."""
    from launcher.bag.ros import static_topics
    from launcher.base.ros_errors import VerbError
    from launcher.ros.messages.interfaces import load_message

    found = static_topics.read(path)
    for topic, type_name in list(found.items()):
        try:
            load_message(type_name)
        except VerbError as error:
            raise UsageError(f"{path}: {topic}: {error.message}", hint=error.hint) from None
        if selection.excludes(topic, type_name):
            warn(f"{topic} of {path} is excluded")
            del found[topic]
    return found


def _check_limits(options: Parsed) -> None:
    if options.snapshot_mode and not options.max_cache_size and not options.max_cache_duration:
        raise UsageError(
            "with --snapshot-mode memory needs a limit: --max-cache-size is 0",
            hint="give --max-cache-size, or --max-cache-duration",
        )
    if options.max_bag_files and not options.max_bag_size and not options.max_bag_duration:
        warn("--max-bag-files has no effect without -b or -d, unless split_bagfile is called")


def _check_names(names: Iterable[str]) -> None:
    """UsageError for what cannot be the name of a topic or a service."""
    from launcher.base.ros_errors import VerbError
    from launcher.ros.topics.listener import full_topic

    for name in names:
        try:
            full_topic(name)
        except VerbError as error:
            raise UsageError(error.message) from None


def _selection(options: Parsed) -> Selection:
    return Selection(
        all_topics=options.all or options.all_topics,
        all_services=options.all or options.all_services,
        all_actions=options.all or options.all_actions,
        topics=names(options.words) | names(options.topics),
        services=names(options.services),
        actions=names(options.actions),
        types=options.topic_types or (),
        regex=options.regex,
        exclude_regex=options.exclude_regex,
        exclude_topics=names(options.exclude_topics),
        exclude_services=names(options.exclude_services),
        exclude_actions=names(options.exclude_actions),
        exclude_types=options.exclude_topic_types or (),
        hidden=options.include_hidden_topics,
    )


_WHAT = (
    option("-a, --all", "all topics, all calls of services, and all actions"),
    option("--all-topics", "all topics"),
    option("--all-services", "calls of all services that publish them (service introspection)"),
    option("--all-actions", "feedback, status and calls of all actions"),
    option("--topics NAME ...", "these topics"),
    option("--services NAME ...", "calls of these services"),
    option("--actions NAME ...", "these actions"),
    option(
        "--static-topics-path FILE",
        "YAML: topics with their types, to subscribe to before they are published",
    ),
    option("--topic-types TYPE ...", "topics of these types"),
    option("-e, --regex REGEX", "topics, services and actions whose names it matches", expression),
    *EXCLUDE,
    option("--exclude-services NAME ...", "not these services"),
    option("--exclude-actions NAME ...", "not these actions"),
    option("--exclude-topic-types TYPE ...", "not topics of these types"),
    option("--include-hidden-topics", "hidden topics as well"),
    option("--include-unpublished-topics", "topics that only have subscriptions as well"),
    option("--ignore-leaf-topics", "not topics without a subscription"),
    option("--no-discovery", "only topics that are there at the start"),
    option(
        "-p, --polling-interval MS",
        "time between two looks for new topics",
        lambda word: count(word, 1, MAX),
        100,
    ),
)
_FILES = (
    option("-o, --output DIR", "folder to make (default: rosbag2_ and the time)"),
    *SPLIT,
    option(
        "--max-cache-size BYTES",
        "memory for messages that wait to be written, and in --snapshot-mode; 0 is unlimited "
        "(default: 100M)",
        byte_count,
        _CACHE_BYTES,
    ),
    option(
        "--max-cache-duration S",
        "whole seconds of messages at most that wait or are in memory; 0 is unlimited",
        lambda word: count(word, 0, _UINT32),
        0,
    ),
    option(
        "--max-bag-files N",
        "keep the last N files, with -b or -d; 0 is all",
        lambda word: count(word, 0, MAX),
        0,
    ),
    option(
        "--repeat-transient-local TOPIC[=DEPTH] ...",
        "begin each further file, and each snapshot, with their last DEPTH (1) messages",
        _repeated,
        name="repeat_transient_local",
    ),
    option(
        "--repeat-all-transient-local [DEPTH]",
        "in the same way DEPTH (1) messages of each topic with a TRANSIENT_LOCAL publisher",
        lambda word: count(word, 0, MAX),
        0,
        value=1,
    ),
    *COMPRESSION,
    option("-s, --storage ID", "format of files", choices=("mcap",), default="mcap"),
    option("--custom-data NAME=VALUE ...", "note it in metadata.yaml", _pair, repeat="all"),
)
_HOW = (
    option("--start-paused", "begin with the space key"),
    option("--use-sim-time", "times of /clock instead of the time of arrival"),
    option(
        "--snapshot-mode",
        "keep messages in memory (--max-cache-size) and write them on the key s or SIGUSR1",
    ),
    option("--qos-profile-overrides-path FILE", "YAML: topic -> policies of its subscription"),
    option("--for S", "end after S seconds", positive_seconds, name="for_s"),
    option("--disable-keyboard-controls", "read no keys"),
    option(
        "--node-name NAME",
        "name of the node with the services of rosbag2's recorder, which are there if "
        "rosbag2_interfaces is installed (default: rosbag2_recorder)",
        _node_name,
    ),
    option(
        "--stats_max_publishing_rate HZ",
        "how often at most the same node publishes what was lost; 0 is never",
        _events_rate,
        1.0,
    ),
    *ignored(
        "-f, --serialization-format FORMAT",
        "--storage-config-file FILE",
        "--compression-queue-size N",
        "--compression-threads N",
        "--compression-threads-priority N",
        "--log-level LEVEL",
    ),
)

COMMAND = ros_command(
    "bag record",
    "record topics until Ctrl-C",
    _record,
    option("[NAME ...]", "topics", name="words"),
    *_WHAT,
    *_FILES,
    *_HOW,
    json=None,
)
