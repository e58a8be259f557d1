"""What steering verbs make of the words of a command line, and of sockets that nobody serves."""

import socket
from pathlib import Path

import pytest

from launcher.commands.control import Settings, take_settings
from launcher.control.runs import all_runs
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


def test_sockets_of_killed_runs_are_told_in_one_line(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    folder = tmp_path / "ros-launcher"
    folder.mkdir(mode=0o700)
    for number in range(3):
        with socket.socket(socket.AF_UNIX) as one:
            one.bind(str(folder / f"{number + 1}-abc.sock"))
            (folder / f"{number + 1}-abc.sock").chmod(0o600)
    told: list[str] = []

    runs = all_runs(told.append)

    ours = [run for run in runs if run.path.parent == folder]
    assert (ours, list(folder.iterdir())) == ([], [])
    assert told == ["removed the sockets of 3 runs that were killed"]
