"""`bag play`: the options of playing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from launcher.bag.verbs.files import INPUT, STORAGES, ignored, inputs
from launcher.bag.verbs.info import warn_of
from launcher.bag.verbs.topics import CALLS, SELECT, names, remapping, selected, warn_of_unknown
from launcher.base.command_line import Parsed
from launcher.base.errors import UsageError
from launcher.base.option import count, number, option, positive_seconds, seconds
from launcher.ros.verb import GraphAccess, ros_command

if TYPE_CHECKING:
    from launcher.bag.reader import Bag

_CLOCK_HZ = 40.0


def _rate(word: str) -> float:
    value = number(word)
    if not 0 < value < math.inf:
        raise ValueError(f"'{word}' is not a positive number")
    return value


def _bar_rate(word: str) -> int:
    try:
        return -1 if word.startswith("-") and count(word[1:], 1) else count(word)
    except ValueError:
        raise ValueError(f"'{word}' is not a whole number of at least -1") from None


def _paths(options: Parsed) -> list[str]:
    """UsageError as ros2 has it: bags are arguments, or follow `-i`."""
    found = list(inputs(options))
    if found and options.bags:
        raise UsageError(
            "bags are arguments, or each follows -i; not both",
            hint=f"-i {options.bags[0]} -i {found[0]}",
        )
    if not found and not options.bags:
        raise UsageError("no bag to play was named", hint=f"usage: {options.command.usage}")
    return found or list(options.bags)


def _bags(options: Parsed) -> list[Bag]:
    from launcher.bag.reader import Bag
    from launcher.packages.absent_ros import require

    try:
        found = [Bag(one) for one in _paths(options)]
    except ModuleNotFoundError:  # only MCAP needs a package
        require("bag play", {"bag": "mcap"})
        raise
    require("bag play", {})
    return found


def _play(options: Parsed) -> int:
    bags = _bags(options)
    from launcher.bag.ros.bag_qos import read_overrides
    from launcher.bag.ros.player import PlayOptions, behind_the_end, play

    path = options.qos_profile_overrides_path
    source = str(options.service_requests_source).partition("_")[0]
    for bag in bags:
        warn_of(bag)
    warn_of_unknown(options, [topic for bag in bags for topic in bag.topics])
    is_sent = options.message_order == "sent"  # the player knows those times
    if not is_sent and all(0 < bag.extent.duration_ns < options.start_offset * 1e9 for bag in bags):
        longest_s = max(bag.extent.duration_ns for bag in bags) / 1e9
        raise UsageError(behind_the_end(longest_s))
    clock_topics = names(options.clock_topics) or None
    return play(
        GraphAccess.of(options),
        bags,
        PlayOptions(
            # A clock of the bag would contradict ours.
            selection=selected(options, without=() if options.clock is None else ["/clock"]),
            overrides={} if path is None else read_overrides(path),
            remap=dict(options.remap or ()),
            rate=options.rate,
            loop=options.loop,
            start_offset_s=options.start_offset,
            duration_s=options.playback_duration,
            until_ns=_until_ns(options),
            delay_s=options.delay,
            clock_hz=options.clock,
            clock_topics=frozenset() if options.clock_topics_all else clock_topics,
            start_paused=options.start_paused,
            acked_s=_acked_s(options.wait_for_all_acked),
            requests=source if options.publish_service_requests else None,
            goals=source if options.send_actions_as_client else None,
            read_ahead=options.read_ahead_queue_size,
            keyboard=not options.disable_keyboard_controls,
            sent=is_sent,
            redraw_s=_redraw_s(options.progress_bar_update_rate),
        ),
    )


def _until_ns(options: Parsed) -> int | None:
    until_ns: int | None = options.playback_until_nsec
    until_s = options.playback_until_sec
    return until_ns if until_s is None else round(until_s * 1e9)


def _redraw_s(rate_hz: int) -> float | None:
    """None for never; for each message if the rate is negative."""
    if not rate_hz:
        return None
    return max(0.0, 1 / rate_hz)


def _acked_s(milliseconds: int) -> float:
    return math.inf if milliseconds == 0 else milliseconds / 1000


COMMAND = ros_command(
    "bag play",
    "publish what bags have",
    _play,
    option("[BAG ...]", "folders, or .mcap and .db3 files", name="bags"),
    INPUT,
    option("-r, --rate FACTOR", "speed", _rate, 1.0),
    option("-l, --loop", "begin again at the end"),
    *SELECT,
    *CALLS,
    option("-m, --remap OLD:=NEW ...", "other names for topics", remapping),
    option(
        "--clock [HZ]",
        "publish the time of the bag on /clock (40 Hz)",
        _rate,
        value=_CLOCK_HZ,
    ),
    option("--clock-topics NAME ...", "publish /clock before each message of these topics"),
    option("--clock-topics-all", "publish /clock before each message"),
    option("-d, --delay S", "begin after S seconds", seconds, 0.0),
    option("-p, --start-paused", "begin with the space key"),
    option("--start-offset S", "begin S seconds behind the start", seconds, 0.0),
    option("--playback-duration S", "end S seconds of the bag later", positive_seconds),
    option("--playback-until-sec S", "end at this time, in seconds since 1970", seconds),
    option("--playback-until-nsec NS", "the same in nanoseconds", count),
    option(
        "--message-order ORDER",
        "order and times: as received, or as sent, which needs --read-ahead-queue-size for as many "
        "messages as one may be late",
        choices=("received", "sent"),
        default="received",
    ),
    option(
        "--wait-for-all-acked MS",
        "at the end, wait so long until RELIABLE subscriptions have everything; 0: for ever",
        count,
        10_000,
    ),
    option("--qos-profile-overrides-path FILE", "YAML: topic -> policies of its publisher"),
    option(
        "--publish-service-requests",
        "call the services of recorded events, instead of publishing the events",
    ),
    option(
        "--send-actions-as-client",
        "send the goals, cancellations and requests for results of recorded events to the server",
    ),
    option(
        "--service-requests-source WHO",
        "whose events are used for these two",
        choices=("service_introspection", "client_introspection"),
        default="service_introspection",
    ),
    option(
        "--read-ahead-queue-size N",
        "messages to read in advance",
        lambda word: count(word, 1),
        1000,
    ),
    option("--disable-keyboard-controls", "read no keys"),
    option(
        "--progress-bar-update-rate HZ",
        "how often the status is drawn on a terminal; 0 is never, -1 with each message",
        _bar_rate,
        5,
    ),
    *ignored(
        "--progress-bar-separation-lines N",
        "--storage-config-file FILE",
        "--disable-loan-message",
        "--log-level LEVEL",
    ),
    option("-s, --storage ID", "ignored, for compatibility with ros2", choices=STORAGES),
    exclusive=(
        ("clock_topics", "clock_topics_all"),
        ("playback_until_sec", "playback_until_nsec"),
    ),
    json=None,
)
