"""`bag play`: the options of playing."""

from __future__ import annotations

import math

from launcher.bag.verbs.info import warn_of
from launcher.bag.verbs.topics import CALLS, SELECT, names, remapping, selected
from launcher.base.command_line import Parsed
from launcher.base.errors import UsageError
from launcher.base.option import count, number, option, positive_seconds, seconds
from launcher.ros.verb import GraphAccess, ros_command

_CLOCK_HZ = 40.0


def _rate(word: str) -> float:
    value = number(word)
    if not 0 < value < math.inf:
        raise ValueError(f"'{word}' is not a positive number")
    return value


def _play(options: Parsed) -> int:
    from launcher.bag.reader import Bag
    from launcher.bag.ros.bag_qos import read_overrides
    from launcher.bag.ros.player import PlayOptions, play

    path, until_s = options.qos_profile_overrides_path, options.playback_until_sec
    bags = [Bag(one) for one in options.bags]
    for bag in bags:
        warn_of(bag)
    if all(0 < bag.extent.duration_ns < options.start_offset * 1e9 for bag in bags):
        longest_s = max(bag.extent.duration_ns for bag in bags) / 1e9
        raise UsageError(f"--start-offset is behind the end: the bag has {longest_s:.3f} s")
    clock_topics = names(options.clock_topics) or None
    return play(
        GraphAccess.of(options),
        bags,
        PlayOptions(
            selection=selected(options),
            overrides={} if path is None else read_overrides(path),
            remap=dict(options.remap or ()),
            rate=options.rate,
            loop=options.loop,
            start_offset_s=options.start_offset,
            duration_s=options.playback_duration,
            until_ns=None if until_s is None else round(until_s * 1e9),
            delay_s=options.delay,
            clock_hz=options.clock,
            clock_topics=frozenset() if options.clock_topics_all else clock_topics,
            start_paused=options.start_paused,
            acked_s=_acked_s(options.wait_for_all_acked),
            requests=_requests(options),
            read_ahead=options.read_ahead_queue_size,
            keyboard=not options.disable_keyboard_controls,
        ),
    )


def _requests(options: Parsed) -> str | None:
    """Whose events become requests, or None if they are published as they are."""
    if not options.publish_service_requests:
        return None
    return str(options.service_requests_source).partition("_")[0]


def _acked_s(milliseconds: int) -> float:
    return math.inf if milliseconds == 0 else milliseconds / 1000


COMMAND = ros_command(
    "bag play",
    "publish what bags have",
    _play,
    option("BAG ...", "folders, or .mcap and .db3 files", name="bags"),
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
        "--service-requests-source WHO",
        "whose events are used",
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
    exclusive=(("clock_topics", "clock_topics_all"),),
    json=None,
)
