"""Options of the verbs that subscribe or publish, and what they say."""

from __future__ import annotations

from typing import TYPE_CHECKING

from launcher.base.command_line import Parsed
from launcher.base.option import count, option
from launcher.ros.topics.qos import MAX_DEPTH, POLICIES, PRESETS, QosOptions
from launcher.ros.verb import seconds

if TYPE_CHECKING:
    from launcher.ros.messages.to_yaml import Style


def natural(word: str) -> int:
    """A whole number; ValueError with the text of ros2cli."""
    try:
        return count(word, 0, MAX_DEPTH)
    except ValueError:
        raise ValueError("value must be non-negative integer") from None


# As ros2cli names them.
QOS = (
    (
        "QoS",
        (
            option("--qos-profile NAME", "preset to start from", choices=PRESETS),
            option("--qos-depth N", "length of the queue", lambda word: count(word, 1, MAX_DEPTH)),
            *(option(f"--qos-{name} POLICY", choices=known) for name, known in POLICIES.items()),
            option("--qos-liveliness-lease-duration-seconds S", "lease duration", seconds),
        ),
    ),
)
STYLE = (
    option("--csv", "print values separated by commas"),
    option("-f, --full-length", "do not truncate"),
    option("-l, --truncate-length N", "truncate arrays, bytes and strings after N", natural, 128),
    option("--no-arr", "print the sizes of arrays only"),
    option("--no-str", "print the lengths of strings only"),
    option("--flow-style", "print each list on one line"),
)


def qos_options(options: Parsed) -> QosOptions:
    return QosOptions(
        preset=options.qos_profile,
        depth=options.qos_depth,
        **{name: getattr(options, f"qos_{name}") for name in POLICIES},
        lease_s=options.qos_liveliness_lease_duration_seconds,
    )


def style(options: Parsed) -> Style:
    from launcher.ros.messages.to_yaml import Style

    return Style(
        length=None if options.full_length or options.json else options.truncate_length,
        no_arr=options.no_arr,
        no_str=options.no_str,
        flow=options.flow_style,
    )
