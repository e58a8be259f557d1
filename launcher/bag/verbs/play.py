"""`bag play`: the options of playing."""

from __future__ import annotations

import math

from launcher.bag.verbs.topics import SELECT, remapping
from launcher.base.by_name import lazy
from launcher.base.command_line import count, number, option, positive_seconds, seconds
from launcher.ros.verb import ros_command

_CLOCK_HZ = 40.0


def _rate(word: str) -> float:
    value = number(word)
    if not 0 < value < math.inf:
        raise ValueError(f"'{word}' is not a positive number")
    return value


COMMAND = ros_command(
    "bag play",
    "publish what bags have",
    lazy("launcher.bag.ros.play:play"),
    option("BAG ...", "folders, or .mcap and .db3 files", name="bags"),
    option("-r, --rate FACTOR", "speed", _rate, 1.0),
    option("-l, --loop", "begin again at the end"),
    *SELECT,
    option("--services NAME ...", "events of these services"),
    option("--exclude-services NAME ...", "not events of these services"),
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
        lambda word: count(word, 0),
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
)
