"""What steering verbs make of the words of a command line."""

import pytest

from launcher.commands.control import Settings, take_settings
from launcher.control.verbs import VERBS, parse
from launcher.errors import UsageError

# What each verb that a shell knows may be given, without the options of all verbs.
WORDS = {
    "ps": "a",
    "top": "a -p 2",
    "kill": "a -s INT",
    "level": "WARN a",
    "grep": "found a",
    "logs": "a -n 3",
    "send": "a some text",
    "events": "--new",
    "quit": "",
} | dict.fromkeys(
    ("stop", "start", "restart", "pause", "resume", "mute", "unmute", "solo", "info"), "a"
)


@pytest.mark.parametrize("verb", [one for one in VERBS if one.shell], ids=lambda one: one.name)
def test_options_of_all_verbs_are_taken_wherever_they_stand(verb):
    words = WORDS[verb.name].split()
    alone = parse(verb, take_settings(verb.name, words)[1])
    for settings in (["--run", "4711", "--json"], ["--json", "--run=4711"]):
        for mixed in ([*settings, *words], [*words[:1], *settings, *words[1:]], words + settings):
            taken, rest = take_settings(verb.name, mixed)
            assert taken == Settings(run="4711", as_json=True), mixed
            assert parse(verb, rest) == alone, mixed


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("a -- --run x", "--run x"),
        ("a --json -- set --json", "set --json"),
        ("a set -- --json", "set --json"),
        ("a -- x -- y", "x -- y"),
        ("a -5 -n", "-5 -n"),
        ("-- a --run x", "--run x"),
    ],
)
def test_a_text_with_dashes_goes_behind_two_of_them(line, text):
    verb = next(one for one in VERBS if one.name == "send")

    call = parse(verb, take_settings("send", line.split())[1])

    assert (call.names, call.options) == (("a",), {"text": text})


@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("send", "a text --ru x", "send has no option '--ru'"),
        ("ps", "--run", "--run needs the id of a run"),
        ("ps", "--run=", "--run needs the id of a run"),
        ("send", "a text --run --json", "--run needs the id of a run"),
    ],
)
def test_what_was_meant_as_an_option_is_no_text_and_no_run(name, line, says):
    with pytest.raises(UsageError, match=says):
        take_settings(name, line.split())
