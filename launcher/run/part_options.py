"""Options of parts of a run that other verbs have as well."""

from __future__ import annotations

import os

from launcher.base.option import Option, count, lazy, option

DISCOVERY = option(
    "--discovery MODE",
    "how nodes on several hosts find each other (default: as the hosts file or the environment "
    "says)",
    choices=("multicast", "peers", "server"),
    repeat="once",
)
COMPOSE = option(
    "--compose NAME",
    "run the Python nodes that match in one process, which needs less memory; NAME may be a "
    "pattern",
    default=(),
    repeat="all",
)
SKIP_HOST = option(
    "--skip-host NAME",
    "do without a host of the hosts file: what would run there is not started; NAME may be a "
    "pattern",
    name="skip_hosts",
    default=(),
    repeat="all",
)
PRIVATE = option(
    "--private",
    "run in a ROS domain that is free, whatever ROS_DOMAIN_ID is; the first lines say which",
)
CHAOS = option(
    "--chaos FILE", "inject faults by the plan in this file", os.path.abspath, name="chaos_plan"
)
RECORDING = (
    option(
        "--record[=all]",
        "keep the last messages of all topics in memory, and write them with logs and events when "
        "a process dies, and at `snapshot`; all: write every message into the folder of the run",
        lazy("launcher.bag.flight.recording:parse_mode"),
        repeat="once",
    ),
    option(
        "--record-keep 60s,256M",
        "how long --record keeps messages, and how much memory they may take",
        lazy("launcher.bag.flight.recording:parse_keep"),
        repeat="once",
    ),
    option(
        "--record-topics REGEX",
        "record only topics whose names it matches",
        lazy("launcher.bag.flight.recording:parse_topics"),
    ),
)


def page_options(prefix: str) -> tuple[Option, ...]:
    """Options about the page in the browser, such as `--web-port` for the prefix `web-`."""
    return (
        option(
            f"--{prefix}port N",
            "port of the page (default: 8770, or any if that is taken; 0: any)",
            lambda word: count(word, 0, 65535),
            repeat="once",
        ),
        option(
            f"--{prefix}host ADDRESS",
            "address to listen on (default: 127.0.0.1); others can be reached from other machines",
            repeat="once",
        ),
        option(
            f"--{prefix}tls CERT,KEY",
            "files in PEM: encrypt the page, for an address that others can reach",
            lazy("launcher.web.page_options:parse_tls"),
            repeat="once",
        ),
        option(
            f"--{prefix}token FILE",
            "use the token in this file in place of a new one",
            os.path.abspath,
            repeat="once",
        ),
        option(f"--{prefix}read-only", "the page only shows, and changes nothing"),
    )
