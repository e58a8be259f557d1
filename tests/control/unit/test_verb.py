"""How control verbs parse their arguments, and stale sockets."""

import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.base.run_verb import Call
from launcher.control.active_runs import all_runs
from launcher.control.client import Connection
from launcher.control.verb import command_of
from launcher.control.verbs import VERBS, call_of, find, parse, parsed_by
from launcher.posix import socket_directory
from launcher.posix.socket_directory import ControlError

# What each verb that a shell knows may be given, without the options of all verbs.
WORDS = {
    "ps": "a",
    "top": "a -p 2",
    "kill": "a -s INT",
    "level": "WARN a",
    "loglevel": "a a.part debug",
    "grep": "found a",
    "inject": "a drop /scan 50 --for 2s",
    "format": "compact",
    "logs": "a -n 3",
    "stack": "a --native",
    "debug": "a --port 5678",
    "send": "a some text",
    "events": "--new",
    "snapshot": "why",
    "show": "",
    "detach": "",
    "quit": "",
    "reload": "--dry-run",
    "watch": "on a",
} | dict.fromkeys(
    ("stop", "start", "restart", "pause", "resume", "mute", "unmute", "solo", "info"), "a"
)


def read(name: str, words: list[str]) -> tuple[Call, str | None, bool]:
    """(the call, --run, --json) of the words behind a verb."""
    verb = find(name)
    assert verb is not None
    parsed = parsed_by(command_of(verb), words)
    return call_of(verb, parsed), parsed.run, parsed.json


@pytest.mark.parametrize("verb", [one for one in VERBS if one.shell], ids=lambda one: one.name)
def test_options_of_all_verbs_are_taken_wherever_they_stand(verb):
    words = WORDS[verb.name].split()
    alone, *_ = read(verb.name, words)
    for settings in (["--run", "4711", "--json"], ["--json", "--run=4711"]):
        for mixed in ([*settings, *words], [*words[:1], *settings, *words[1:]], words + settings):
            assert read(verb.name, mixed) == (alone, "4711", True), mixed


def test_a_template_without_quotes_gets_a_hint():
    verb = find("format")
    assert verb is not None
    with pytest.raises(UsageError, match=r"unexpected argument '\{message\}'") as of_shell:
        read("format", ["{clock}", "{message}", "--run", "x"])
    with pytest.raises(UsageError, match="unexpected argument") as of_console:
        parse(verb, ["{clock}", "{message}"])
    with pytest.raises(UsageError) as other:
        parse(verb, ["default", "compact"])
    hint = "a template with blanks needs quotes: format '{clock} {message}'"
    assert (of_shell.value.hint, of_console.value.hint) == (hint, hint)
    assert other.value.hint == "usage: format [FORMAT]"


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
    call, *_ = read("send", line.split())
    assert (call.names, call.options) == (("a",), {"text": text})


@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("send", "a text --ru x", "unknown option '--ru'"),
        ("ps", "--run", "--run needs a value: ID"),
        ("ps", "--run=", "--run: the id of a run is missing"),
        ("send", "a text --run --json", "--run needs a value: ID"),
    ],
)
def test_a_misspelt_or_incomplete_option_is_an_error(name, line, says):
    with pytest.raises(UsageError, match=says):
        read(name, line.split())


def test_sockets_of_killed_runs_are_reported_in_one_line(tmp_path: Path, monkeypatch):
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


def test_a_note_about_a_socket_has_its_path_once(tmp_path: Path, monkeypatch):
    path = tmp_path / "1-abc.sock"
    monkeypatch.setattr(socket_directory, "sockets", lambda env, uid: [path])
    notes: list[str] = []
    monkeypatch.setattr(Connection, "__init__", refuse(ControlError(f"{path}: Connection reset")))
    all_runs(notes.append)
    monkeypatch.setattr(Connection, "__init__", refuse(ControlError("no answer")))
    all_runs(notes.append)
    assert notes == [f"{path}: Connection reset", f"{path}: no answer"]


def refuse(error: Exception) -> Callable[..., None]:
    def raising(*args: object, **more: object) -> None:
        raise error

    return raising
