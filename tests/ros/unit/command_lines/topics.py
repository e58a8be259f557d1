"""Command lines of `topic`, and what they mean."""

from __future__ import annotations

from tests.ros.unit.command_lines.options import BASE, QOS, Line

ECHO = {
    **BASE,
    **QOS,
    "once": False,
    "timeout": None,
    "field": (),
    "filter": None,
    "csv": False,
    "full_length": False,
    "truncate_length": 128,
    "no_arr": False,
    "no_str": False,
    "flow_style": False,
    "raw": False,
    "include_message_info": False,
    "clear": False,
    "node_name": None,
}
HZ = {**BASE, **QOS, "window": 10000, "filter": None, "for_s": None, "min_hz": None}
HZ |= {"use_sim_time": False, "all": False, "include_hidden_topics": False}
BW = {**BASE, **QOS, "window": 100, "for_s": None, "all": False, "include_hidden_topics": False}
DELAY = {**BASE, **QOS, "window": 10000, "for_s": None}
PUB = {
    **BASE,
    **QOS,
    "values": "",
    "stdin": False,
    "yaml_file": None,
    "rate": 1.0,
    "print": 1,
    "once": False,
    "times": None,
    "wait_matching_subscriptions": None,
    "max_wait_time_secs": None,
    "keep_alive": 0.1,
    "node_name": None,
    "use_sim_time": False,
}
LISTED = {**BASE, "show_types": False, "include_hidden_topics": False, "count_topics": False}
LISTED["verbose"] = False
INFO = {**BASE, "verbose": False, "explain": False}

LINES: list[Line] = [
    ("topic list", LISTED, {}),
    (
        "topic list -t -v -c",
        LISTED,
        {"show_types": True, "verbose": True, "count_topics": True},
    ),
    ("topic list -tv", LISTED, {"show_types": True, "verbose": True}),
    ("topic list --include-hidden-topics", LISTED, {"include_hidden_topics": True}),
    ("topic list --include", LISTED, {"include_hidden_topics": True}),
    (
        "topic list -d 5 --spin-time 2 --json",
        LISTED,
        {"domain": "5", "spin_time": 2.0, "json": True},
    ),
    ("topic list -d5 --spin-time=.5", LISTED, {"domain": "5", "spin_time": 0.5}),
    (
        "topic list --domain=7 --no-observer --no-daemon",
        LISTED,
        {"domain": "7", "no_observer": True},
    ),
    ("topic info /t -v", INFO, {"topic_name": "/t", "verbose": True}),
    ("topic info --explain -- /t", INFO, {"topic_name": "/t", "explain": True}),
    ("topic echo /t", ECHO, {"words": ["/t"]}),
    (
        "topic echo --once /t std_msgs/String",
        ECHO,
        {"words": ["/t", "std_msgs/String"], "once": True},
    ),
    (
        "topic echo /a /b --csv -f",
        ECHO,
        {"words": ["/a", "/b"], "csv": True, "full_length": True},
    ),
    ("topic echo /a -l 5 --raw", ECHO, {"words": ["/a"], "truncate_length": 5, "raw": True}),
    (
        "topic echo /a -l5 -i",
        ECHO,
        {"words": ["/a"], "truncate_length": 5, "include_message_info": True},
    ),
    (
        "topic echo /a --timeout 3 --field x.y[0]",
        ECHO,
        {"words": ["/a"], "timeout": 3.0, "field": ("x.y[0]",)},
    ),
    (
        "topic echo /a --field x --field y.[1].z",
        ECHO,
        {"words": ["/a"], "field": ("x", "y.[1].z")},
    ),
    ("topic echo /a --clear -n ear", ECHO, {"words": ["/a"], "clear": True, "node_name": "ear"}),
    ("topic echo -c /a T", ECHO, {"words": ["/a", "T"], "clear": True}),
    ("topic echo /a --filter 'm.x > 1'", ECHO, {"words": ["/a"], "filter": "m.x > 1"}),
    (
        "topic echo /a --no-arr --no-str --flow-style",
        ECHO,
        {"words": ["/a"], "no_arr": True, "no_str": True, "flow_style": True},
    ),
    ("topic echo /a --no-lost-messages", ECHO, {"words": ["/a"]}),
    (
        "topic echo /a --qos-profile sensor_data --qos-depth 3",
        ECHO,
        {"words": ["/a"], "qos_profile": "sensor_data", "qos_depth": 3},
    ),
    (
        "topic echo /a --qos-reliability best_effort --qos-durability=volatile",
        ECHO,
        {"words": ["/a"], "qos_reliability": "best_effort", "qos_durability": "volatile"},
    ),
    (
        "topic echo /a --qos-history keep_all --qos-liveliness automatic",
        ECHO,
        {"words": ["/a"], "qos_history": "keep_all", "qos_liveliness": "automatic"},
    ),
    (
        "topic echo /a --qos-liveliness-lease-duration-seconds 2",
        ECHO,
        {"words": ["/a"], "qos_liveliness_lease_duration_seconds": 2.0},
    ),
    ("topic hz /a /b -w 4", HZ, {"topic_names": ["/a", "/b"], "window": 4}),
    (
        "topic hz /a --for 3 --min 2.5 --wall-time",
        HZ,
        {"topic_names": ["/a"], "for_s": 3.0, "min_hz": 2.5},
    ),
    ("topic hz /a --filter m.x", HZ, {"topic_names": ["/a"], "filter": "m.x"}),
    ("topic hz --all", HZ, {"topic_names": [], "all": True}),
    ("topic hz -a -w 5", HZ, {"topic_names": [], "all": True, "window": 5}),
    ("topic bw /a --window=3 --for=1", BW, {"topic_names": ["/a"], "window": 3, "for_s": 1.0}),
    ("topic bw /a /b", BW, {"topic_names": ["/a", "/b"]}),
    ("topic bw -a", BW, {"all": True}),
    ("topic delay /a", DELAY, {"topic_name": "/a"}),
    ("topic pub /a T --yaml-file f -r 5", PUB, {"yaml_file": "f", "rate": 5.0}),
    ("topic pub /a T", PUB, {"topic_name": "/a", "message_type": "T"}),
    (
        "topic pub /a T 'data: 1' -1",
        PUB,
        {"topic_name": "/a", "message_type": "T", "values": "data: 1", "once": True},
    ),
    (
        "topic pub --once /a T 'data: 1'",
        PUB,
        {"topic_name": "/a", "message_type": "T", "values": "data: 1", "once": True},
    ),
    (
        "topic pub /a T '- a b'",
        PUB,
        {"topic_name": "/a", "message_type": "T", "values": "- a b"},
    ),
    (
        "topic pub /a T --stdin -r 5 -p 2 -t 3",
        PUB,
        {
            "topic_name": "/a",
            "message_type": "T",
            "stdin": True,
            "rate": 5.0,
            "print": 2,
            "times": 3,
        },
    ),
    (
        "topic pub /a T -r10 -w 0 --keep-alive 0",
        PUB,
        {
            "topic_name": "/a",
            "message_type": "T",
            "rate": 10.0,
            "wait_matching_subscriptions": 0,
            "keep_alive": 0.0,
        },
    ),
    (
        "topic pub /a T -1 --max-wait-time-secs 2 -n talker -s",
        PUB,
        {
            "topic_name": "/a",
            "message_type": "T",
            "once": True,
            "max_wait_time_secs": 2.0,
            "node_name": "talker",
            "use_sim_time": True,
        },
    ),
    ("topic hz /a -s", HZ, {"topic_names": ["/a"], "use_sim_time": True}),
    ("topic type /a", BASE, {"topic_name": "/a"}),
    (
        "topic find T -c --include-hidden-topics",
        BASE,
        {"topic_type": "T", "count_topics": True, "include_hidden_topics": True},
    ),
]
