"""Command lines of `service`, `action` and `interface`, and what they mean."""

from __future__ import annotations

from tests.ros.unit.command_lines.options import BASE, QOS, Line

CALL = {**BASE, **QOS, "values": "", "stdin": False, "rate": None, "timeout": None}
SERVICES = {**BASE, "show_types": False, "count_services": False}
SERVICES["include_hidden_services"] = False
EVENTS = {
    **BASE,
    **QOS,
    "service_type": None,
    "timeout": None,
    "csv": False,
    "full_length": False,
    "truncate_length": 128,
    "no_arr": False,
    "no_str": False,
    "flow_style": False,
}
GOAL = {**BASE, "goal": "", "stdin": False, "feedback": False, "timeout": None}
ACTION_EVENTS = {**EVENTS, "action_type": None, "interfaces": None}
ACTION_EVENTS.pop("service_type")
TYPES = {**BASE, "only_msgs": False, "only_srvs": False, "only_actions": False}
SHOW = {**BASE, "type": "T", "all_comments": False, "no_comments": False}

LINES: list[Line] = [
    ("service list -t -c", SERVICES, {"show_types": True, "count_services": True}),
    ("service type /s", BASE, {"service_name": "/s"}),
    (
        "service find T -c",
        BASE,
        {"service_type": "T", "count_services": True, "include_hidden_services": False},
    ),
    ("service call /s T", CALL, {"service_name": "/s", "service_type": "T"}),
    (
        "service call /s T '{a: 1}' -r 2 --timeout 3",
        CALL,
        {
            "service_name": "/s",
            "service_type": "T",
            "values": "{a: 1}",
            "rate": 2.0,
            "timeout": 3.0,
        },
    ),
    (
        "service call --stdin /s T",
        CALL,
        {"service_name": "/s", "service_type": "T", "stdin": True},
    ),
    (
        "service call /s T --qos-profile sensor_data --qos-depth 2",
        CALL,
        {"qos_profile": "sensor_data", "qos_depth": 2},
    ),
    ("service info /s", BASE, {"service_name": "/s", "verbose": False}),
    ("service info -v /s", BASE, {"service_name": "/s", "verbose": True}),
    ("service echo /s", EVENTS, {"service_name": "/s"}),
    (
        "service echo /s T --csv --no-arr --no-str -l 5 --timeout 2",
        EVENTS,
        {
            "service_type": "T",
            "csv": True,
            "no_arr": True,
            "no_str": True,
            "truncate_length": 5,
            "timeout": 2.0,
        },
    ),
    (
        "service echo -f --flow-style /s --qos-depth 3",
        EVENTS,
        {"full_length": True, "flow_style": True, "qos_depth": 3},
    ),
    ("action list -t -c", BASE, {"show_types": True, "count_actions": True}),
    ("action list --count", BASE, {"show_types": False, "count_actions": True}),
    ("action info /a -tc", BASE, {"action_name": "/a", "show_types": True, "count": True}),
    ("action type /a", BASE, {"action_name": "/a"}),
    ("action find T -c", BASE, {"action_type": "T", "count_actions": True}),
    ("action send_goal /a T", GOAL, {"action_name": "/a", "action_type": "T"}),
    ("action send_goal /a T '{a: 1}' -f", GOAL, {"goal": "{a: 1}", "feedback": True}),
    ("action send_goal -f --stdin /a T", GOAL, {"stdin": True, "feedback": True}),
    ("action send_goal /a T --timeout 3 --json", GOAL, {"timeout": 3.0, "json": True}),
    ("action send_goal /a T -t 3", GOAL, {"timeout": 3.0}),
    ("action send_goal -t0 /a T", GOAL, {"timeout": 0.0}),
    ("action echo /a", ACTION_EVENTS, {"action_name": "/a"}),
    (
        "action echo /a T -i 'GOAL_SERVICE|status_topic' --csv -l 5",
        ACTION_EVENTS,
        {
            "action_name": "/a",
            "action_type": "T",
            "interfaces": "GOAL_SERVICE|status_topic",
            "csv": True,
            "truncate_length": 5,
        },
    ),
    (
        "action echo --flow-style --no-arr --no-str -f /a --qos-depth 3 --json",
        ACTION_EVENTS,
        {
            "flow_style": True,
            "no_arr": True,
            "no_str": True,
            "full_length": True,
            "qos_depth": 3,
            "json": True,
        },
    ),
    ("interface list -m -s", TYPES, {"only_msgs": True, "only_srvs": True}),
    ("interface list -a", TYPES, {"only_actions": True}),
    ("interface package p -m", TYPES, {"package": "p", "only_msgs": True}),
    ("interface packages -s -a", TYPES, {"only_srvs": True, "only_actions": True}),
    ("interface show T --all-comments", SHOW, {"all_comments": True}),
    ("interface show -", SHOW, {"type": "-"}),
    ("interface show T --no-comments", SHOW, {"no_comments": True}),
    ("interface proto T --no-quotes", BASE, {"type": "T", "no_quotes": True}),
]
