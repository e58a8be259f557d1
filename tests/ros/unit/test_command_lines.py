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
from tests.ros.unit.command_lines import nodes, services, topics


def command(verb: str) -> Command:
    made: Command = importlib.import_module(module_of(verb)).COMMAND
    return made


def understood(verb: str, words: list[str]) -> tuple[str, dict[str, Any]]:
    """(the verb below, its options) that a ROS verb makes of its words."""
    options = vars(command(verb).parse(words))
    return options["command"].name.rpartition(" ")[2], options


@pytest.mark.parametrize(
    ("line", "base", "changes"),
    [*topics.LINES, *nodes.LINES, *services.LINES],
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
        "param get",
        "param set /n",
        "service call /s",
        "service call /s T x --stdin",
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
        "action echo",
        "action echo /a T x",
        "action send_goal /a T {} --stdin",
        "topic hz",
        "topic hz /a --all",
        "topic hz --all --for 1 --min 2",
        "topic bw",
        "topic bw /a -a",
        "topic delay /a /b",
        "topic pub /a T {} --stdin",
        "topic pub /a T {} --yaml-file f",
        "topic pub /a T --stdin --yaml-file f",
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
        "multicast send --group 10.0.0.1",
        "multicast receive --port 0",
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
