"""How the ROS verbs parse their arguments; these command lines must keep their meaning."""

from __future__ import annotations

import importlib
import shlex
from typing import Any

import pytest

from launcher.base.command_line import Command
from launcher.base.errors import UsageError
from launcher.base.verb_table import module_of
from launcher.cli import dispatch as cli
from launcher.ros.front import verb_first


def command(verb: str) -> Command:
    made: Command = importlib.import_module(module_of(verb)).COMMAND
    return made


def understood(verb: str, words: list[str]) -> tuple[str, dict[str, Any]]:
    """(the verb below, its options) that a ROS verb makes of its words."""
    options = vars(command(verb).parse(words))
    return options["command"].name.rpartition(" ")[2], options


BASE = {"domain": None, "spin_time": None, "json": False, "no_observer": False}
QOS = dict.fromkeys(
    [
        "qos_profile",
        "qos_depth",
        "qos_reliability",
        "qos_durability",
        "qos_liveliness",
        "qos_history",
        "qos_liveliness_lease_duration_seconds",
    ]
)
ECHO = {
    **BASE,
    **QOS,
    "once": False,
    "timeout": None,
    "field": None,
    "filter": None,
    "csv": False,
    "full_length": False,
    "truncate_length": 128,
    "no_arr": False,
    "no_str": False,
    "flow_style": False,
    "raw": False,
    "include_message_info": False,
}
HZ = {**BASE, **QOS, "window": 10000, "filter": None, "for_s": None, "min_hz": None}
HZ["use_sim_time"] = False
BW = {**BASE, **QOS, "window": 100, "for_s": None}
PUB = {
    **BASE,
    **QOS,
    "values": "",
    "stdin": False,
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
GRAPH = {
    **BASE,
    "mode": "all",
    "include": None,
    "exclude": None,
    "debug_topics": False,
    "hidden": False,
    "dot": False,
    "mermaid": False,
    "svg": None,
    "html": None,
    "watch": False,
    "diff": None,
    "period": 0.5,
}
LISTED = {**BASE, "show_types": False, "include_hidden_topics": False, "count_topics": False}
LISTED["verbose"] = False
INFO = {**BASE, "verbose": False, "explain": False}
NODE = {**BASE, "node_name": "/n", "include_hidden_nodes": False, "timeout": None}
PARAMS = {**NODE, "param_prefixes": (), "param_type": False, "filter": None}
CALL = {**BASE, "values": "", "stdin": False, "rate": None, "timeout": None}
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
LIFECYCLE = {**BASE, "node_name": "/n", "timeout": None}
STATES = {**LIFECYCLE, "transitions": False}
TYPES = {**BASE, "only_msgs": False, "only_srvs": False, "only_actions": False}
SHOW = {**BASE, "type": "T", "all_comments": False, "no_comments": False}


@pytest.mark.parametrize(
    ("line", "base", "changes"),
    [
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
            {"words": ["/a"], "timeout": 3.0, "field": "x.y[0]"},
        ),
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
        ("topic bw /a --window=3 --for=1", BW, {"topic_name": "/a", "window": 3, "for_s": 1.0}),
        ("topic delay /a", BW, {"topic_name": "/a", "window": 10000}),
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
        ("node list -a -c", BASE, {"all": True, "count_nodes": True}),
        ("node list -ac", BASE, {"all": True, "count_nodes": True}),
        ("node info /n --include-hidden", BASE, {"node_name": "/n", "include_hidden": True}),
        ("node ps --all --answer-timeout 2", BASE, {"all": True, "answer_timeout": 2.0}),
        ("node ps", BASE, {"all": False, "answer_timeout": 1.0}),
        ("param list", PARAMS, {"node_name": None}),
        ("param list /n --param-type", PARAMS, {"param_type": True}),
        ("param list /n --param-prefixes a b", PARAMS, {"param_prefixes": ["a", "b"]}),
        ("param list --param-prefixes a b -- /n", PARAMS, {"param_prefixes": ["a", "b"]}),
        (
            "param list --param-prefixes a b --json /n",
            PARAMS,
            {"param_prefixes": ["a", "b"], "json": True},
        ),
        ("param list --param-prefixes=a /n", PARAMS, {"param_prefixes": ["a"]}),
        ("param get /n p --hide-type", NODE, {"parameter_name": "p", "hide_type": True}),
        ("param set /n p 1 q 2 --atomic", NODE, {"pairs": ["p", "1", "q", "2"], "atomic": True}),
        ("param delete /n p --timeout 2", NODE, {"parameter_name": "p", "timeout": 2.0}),
        ("param set /n p -5", NODE, {"pairs": ["p", "-5"], "atomic": False}),
        ("param set /n p -1.5", NODE, {"pairs": ["p", "-1.5"], "atomic": False}),
        ("param set /n p -- -x", NODE, {"pairs": ["p", "-x"], "atomic": False}),
        (
            "param describe /n p q --include-hidden-nodes",
            NODE,
            {"parameter_names": ["p", "q"], "include_hidden_nodes": True},
        ),
        ("param dump /n", NODE, {}),
        (
            "param load /n f.yaml --no-use-wildcard --timeout 3",
            NODE,
            {"parameter_file": "f.yaml", "no_use_wildcard": True, "timeout": 3.0},
        ),
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
        ("service info /s", BASE, {"service_name": "/s"}),
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
        ("lifecycle nodes", BASE, {"include_hidden_nodes": False, "count_nodes": False}),
        ("lifecycle nodes -a -c", BASE, {"include_hidden_nodes": True, "count_nodes": True}),
        ("lifecycle nodes --all --spin-time 1", BASE, {"spin_time": 1.0}),
        ("lifecycle list /n", LIFECYCLE, {"all": False}),
        ("lifecycle list /n -a --include-hidden-nodes", LIFECYCLE, {"all": True}),
        ("lifecycle get", STATES, {"node_name": None}),
        ("lifecycle get /n --timeout 2 -t", STATES, {"timeout": 2.0, "transitions": True}),
        ("lifecycle get --include-hidden-nodes", STATES, {"node_name": None}),
        ("lifecycle set /n configure", LIFECYCLE, {"transition": "configure"}),
        ("lifecycle set /n 3 --timeout 9", LIFECYCLE, {"transition": "3", "timeout": 9.0}),
        ("interface list -m -s", TYPES, {"only_msgs": True, "only_srvs": True}),
        ("interface list -a", TYPES, {"only_actions": True}),
        ("interface package p -m", TYPES, {"package": "p", "only_msgs": True}),
        ("interface packages -s -a", TYPES, {"only_srvs": True, "only_actions": True}),
        ("interface show T --all-comments", SHOW, {"all_comments": True}),
        ("interface show -", SHOW, {"type": "-"}),
        ("interface show T --no-comments", SHOW, {"no_comments": True}),
        ("interface proto T --no-quotes", BASE, {"type": "T", "no_quotes": True}),
        ("graph", GRAPH, {}),
        ("graph --dot --mode nodes", GRAPH, {"dot": True, "mode": "nodes"}),
        (
            "graph --mermaid --include a --exclude=b",
            GRAPH,
            {"mermaid": True, "include": "a", "exclude": "b"},
        ),
        (
            "graph --svg f.svg --debug-topics --hidden",
            GRAPH,
            {"svg": "f.svg", "debug_topics": True, "hidden": True},
        ),
        ("graph --html=f.html", GRAPH, {"html": "f.html"}),
        ("graph --watch --period 2", GRAPH, {"watch": True, "period": 2.0}),
        ("graph --diff f.json --json -d 3", GRAPH, {"diff": "f.json", "json": True, "domain": "3"}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_words_of_a_ros_verb(line, base, changes):
    verb, *words = shlex.split(line)
    sub, options = understood(verb, words)
    assert sub == ("graph" if verb == "graph" else words[0])
    expected = {**base, **changes}
    assert {name: options[name] for name in expected} == expected


@pytest.mark.parametrize(
    "line",
    [
        "topic bogus",
        "topic list x",
        "topic list --bogus",
        "topic list --json=1",
        "topic info",
        "topic info a b",
        "topic echo",
        "topic echo /a --timeout",
        "topic echo /a --timeout x",
        "topic echo /a --qos-durability eternal",
        "topic echo /a --qos-depth 0",
        "topic hz /a -w 0",
        "topic pub /a",
        "topic pub /a T --once -t 3",
        "topic pub /a T --rate x",
        "node info",
        "topic list --spin-time -1",
        "topic list --spin-time nan",
        "topic list -z",
        "param get /n",
        "param set /n",
        "service call /s",
        "service info",
        "service info /s /t",
        "service echo",
        "service echo /s T U",
        "service echo /s -l x",
        "service echo /s --timeout -1",
        "action list x",
        "action info",
        "action type",
        "action find",
        "action send_goal /a",
        "action send_goal /a T x y",
        "action send_goal /a T --timeout nan",
        "action echo /a",
        "lifecycle list",
        "lifecycle get a b",
        "lifecycle set /n",
        "lifecycle set /n a b",
        "lifecycle set /n a --timeout x",
        "lifecycle nodes x",
        "interface show T --all-comments --no-comments",
        "interface package",
        "interface packages p",
        "multicast send --ttl 256",
        "multicast receive --timeout 0",
        "daemon restart",
        "graph x",
        "graph --dot --svg f",
        "graph --mode some",
        "graph --svg",
        "topic echo /a -l ²",
        "topic pub /a T --max-wait-time-secs 0",
    ],
)
def test_words_that_no_ros_verb_takes(line):
    verb, *words = line.split()
    with pytest.raises(UsageError):
        importlib.import_module(module_of(verb)).main(words)


@pytest.mark.parametrize(
    ("line", "plain"),
    [
        ("-d 83 topic list", "topic -d 83 list"),
        ("-d83 topic list", "topic -d 83 list"),
        ("--domain=83 graph --dot", "graph --domain=83 --dot"),
        ("--spin-time 2 --json node info /n", "node --spin-time 2 --json info /n"),
        ("--workspace /ws -d 3 topic list", "topic --workspace /ws -d 3 list"),
        ("-d 83 bag play x -d 2", "bag play --domain 83 x -d 2"),
        ("--debug plan system", "plan --debug system"),
        ("--json ps", "ps --json"),
        ("-d x topic list", "topic -d x list"),
        ("-d system", "-d system"),
        ("--debug run p e -d topic", "run --debug p e -d topic"),
        ("--debug system", "--debug system"),
        ("--mute robot_1 system", "--mute robot_1 system"),
    ],
)
def test_options_of_ros_verbs_may_stand_in_front_of_the_verb(line, plain):
    assert verb_first(line.split()) == plain.split()


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    [
        ("-d 83 topc list", "unknown verb 'topc' behind -d", "did you mean 'topic'?"),
        ("-d 83", "the verb behind -d is missing", "it is an option of topic, "),
        ("-d topic list", "-d needs a value: ID", "for example: "),
        ("--spin-time", "--spin-time needs a value: S", None),
        (
            "-d 83 multicast send",
            "-d is not an option of 'multicast'",
            "it is an option of topic, ",
        ),
        ("-d 83 plan system", "-d is not an option of 'plan'", "it is an option of topic, "),
        ("-d 83 --bogus topic list", "unknown option '--bogus' in front of the verb", "it is"),
    ],
)
def test_mistakes_in_front_of_a_ros_verb(line, message, hint):
    with pytest.raises(UsageError) as raised:
        verb_first(line.split())
    assert raised.value.message == message
    assert hint is None or raised.value.hint.startswith(hint)


@pytest.mark.parametrize(
    ("line", "changes"),
    [
        ("topic --include-hidden-topics list -t", {"include_hidden_topics": True}),
        ("topic -d 83 --json list", {"domain": "83", "json": True}),
        ("topic --spin-time=2 info /t", {"spin_time": 2.0, "topic_name": "/t"}),
        ("topic --include-hidden-topics info /t", {"topic_name": "/t"}),
        ("service --include-hidden-services find T", {"include_hidden_services": True}),
        ("node -s --no-daemon list -a", {"all": True}),
    ],
)
def test_options_between_a_ros_verb_and_its_own(line, changes):
    verb, *words = line.split()
    options = vars(command(verb).parse(words))
    assert {name: options[name] for name in changes} == changes


def test_a_wrong_option_between_a_ros_verb_and_its_own_is_named():
    with pytest.raises(UsageError, match=r"^unknown option '--once' in front of the verb$"):
        command("topic").parse(["--once", "echo", "/t"])


@pytest.mark.parametrize(
    "verb", ["topic", "node", "param", "service", "action", "lifecycle", "interface", "bag"]
)
def test_a_ros_verb_alone_prints_its_help(verb, capsys):
    assert cli.main([verb]) == 2
    assert capsys.readouterr().out.startswith(f"usage: python -m launcher {verb}")
