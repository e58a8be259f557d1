"""Selecting processes by name, parsing of verbs and requests, and the socket directory."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.base.run_verb import BadCallError
from launcher.control.protocol import RequestError, parse_request, raw_item, raw_reply
from launcher.control.verbs import VERBS, find, parse
from launcher.posix import socket_directory
from launcher.posix.socket_directory import ControlError
from launcher.run.requests.process_selection import ProcessNames, resolve

FLEET = (
    ProcessNames("dispatcher-1", "dispatcher", ("/fleet/dispatcher",), "/fleet"),
    ProcessNames("robot_1-2", "robot", ("/fleet/north/robot_1",), "/fleet/north"),
    ProcessNames("robot_2-3", "robot", ("/fleet/south/robot_2",), "/fleet/south"),
    ProcessNames("fleetwide-4", "fleetwide", ("/fleetwide",), "/"),
    ProcessNames("sh-5", "sh"),
    ProcessNames("driver-6", "driver", (), "/base"),
)


@pytest.mark.parametrize(
    ("words", "places"),
    [
        (["robot_1-2"], [1]),
        (["dispatcher"], [0]),
        (["robot_2"], [2]),
        (["/fleet/south/robot_2"], [2]),
        (["robot*"], [1, 2]),
        (["robot_?"], [1, 2]),
        (["*"], [0, 1, 2, 3, 4, 5]),
        (["/fleet"], [0, 1, 2]),
        (["/fleet/"], [0, 1, 2]),
        (["/fleet/north"], [1]),
        (["/fleetwide"], [3]),
        (["/"], [0, 1, 2, 3, 5]),
        (["sh-5", "dispatcher", "sh"], [0, 4]),
        (["/fleet/*/robot_1"], [1]),
        (["/base/driver"], [5]),
    ],
)
def test_a_process_has_many_names(words: list[str], places: list[int]):
    assert resolve(words, FLEET) == places


@pytest.mark.parametrize(
    ("word", "code", "told"),
    [
        ("robot", "ambiguous-name", "robot_1-2 or robot_2-3"),
        ("robot_3", "unknown-name", "robot_3"),
        ("/north", "unknown-name", "/north"),
        ("x*", "unknown-name", "x*"),
        ("", "unknown-name", "''"),
    ],
)
def test_an_unknown_or_ambiguous_name_is_an_error(word: str, code: str, told: str):
    with pytest.raises(BadCallError) as error:
        resolve([word], FLEET)
    assert error.value.code == code
    assert told in error.value.message


def test_all_is_no_name_but_has_a_pattern():
    with pytest.raises(BadCallError) as error:
        resolve(["all"], FLEET)
    assert error.value.hint.startswith("'*' stands for all processes; known: ")


def test_the_beginning_of_several_names_is_offered_as_a_pattern():
    fleet = (ProcessNames("robot_1-1", "robot_1"), ProcessNames("robot_2-2", "robot_2"))
    with pytest.raises(BadCallError) as error:
        resolve(["robot"], fleet)
    assert error.value.hint.startswith("did you mean 'robot*'? known: ")


def test_a_name_that_looks_like_a_pattern_is_first_a_name():
    odd = (ProcessNames("a[b]-1", "a[b]"), ProcessNames("ab-2", "ab"))
    assert resolve(["a[b]"], odd) == [0]
    assert resolve(["a[b]-1"], odd) == [0]
    assert resolve(["a[bc]"], odd) == [1]


def scripts(*labels: str, **ros: str) -> list[ProcessNames]:
    """The names of processes whose launch file does not name their nodes."""
    return [
        ProcessNames.of(
            ProcessSpec(
                name=f"{label}-{n}",
                label=label,
                argv=(f"./{label}",),
                env={},
                ros=RosIdentity(**ros),
            )
        )
        for n, label in enumerate(labels, 1)
    ]


@pytest.mark.parametrize("word", ["talker", "/fleet/talker", "t?lker"])
def test_the_suffix_of_a_program_may_be_left_out(word: str):
    assert resolve([word], scripts("talker.py", "listener.sh", namespace="/fleet")) == [0]


def test_a_pattern_finds_programs_without_their_suffix():
    assert resolve(["robot_?"], scripts("robot_1.py", "robot_2.sh", "a.out")) == [0, 1]
    with pytest.raises(BadCallError, match="unknown process 'a'"):
        resolve(["a"], scripts("a.out"))


def test_a_name_or_a_node_comes_before_a_program_without_its_suffix():
    (script,) = scripts("robot.py")
    node = ProcessNames("arm-2", "arm", ("/robot",), "/")
    assert resolve(["robot"], [script, node]) == [1]
    assert resolve(["/robot"], [script, ProcessNames("arm-2", "arm", (), "/robot")]) == [1]
    assert resolve(["robot"], [script, ProcessNames("robot-2", "robot")]) == [1]


def test_two_programs_that_differ_in_their_suffix_are_ambiguous():
    with pytest.raises(BadCallError, match=r"'do' is ambiguous: do.py-1 or do.sh-2") as error:
        resolve(["do"], scripts("do.py", "do.sh"))
    assert error.value.code == "ambiguous-name"


def test_a_near_miss_is_offered_by_the_name_of_the_process():
    with pytest.raises(BadCallError) as error:
        resolve(["dispacher"], FLEET)
    assert error.value.hint.startswith("did you mean 'dispatcher-1'? ")
    with pytest.raises(BadCallError) as error:
        resolve(["robto"], FLEET)
    assert error.value.hint.startswith("did you mean 'robot_1-2' or 'robot_2-3'? ")
    with pytest.raises(BadCallError) as error:
        resolve(["robot_9"], FLEET)
    assert (
        error.value.hint
        == "known: dispatcher-1, robot_1-2, robot_2-3, fleetwide-4, sh-5 and driver-6"
    )


@pytest.mark.parametrize(
    ("line", "names", "options"),
    [
        ("kill a b -s TERM", ["a", "b"], {"signal": signal.SIGTERM}),
        ("kill --signal=9 a", ["a"], {"signal": signal.SIGKILL}),
        ("kill a -s int", ["a"], {"signal": signal.SIGINT}),
        ("kill -9 a", ["a"], {"signal": signal.SIGKILL}),
        ("kill a -TERM", ["a"], {"signal": signal.SIGTERM}),
        ("logs -n 5 -f a", ["a"], {"lines": 5, "follow": True}),
        ("logs", [], {}),
        ("level warn a", ["a"], {"level": "warn"}),
        ("grep", [], {}),
        ("grep task a b", ["a", "b"], {"pattern": "task"}),
        ("grep -- -x a", ["a"], {"pattern": "-x"}),
        ("send a  -n two  words", ["a"], {"text": "-n two words"}),
        ("events -f --new", [], {"follow": True, "history": False}),
        ("top -p 0.5", [], {"period_s": 0.5}),
        ("level", [], {}),
        ("kill -9 a", ["a"], {"signal": 9}),
        ("kill a -KILL", ["a"], {"signal": 9}),
        ("kill a -s 0", ["a"], {"signal": 0}),
        ("kill --help", [], {"topic": "kill"}),
        ("help exit", [], {"topic": "exit"}),
        ("exit", [], {}),
    ],
)
def test_words_become_a_call(line: str, names: list[str], options: dict[str, object]):
    verb, *words = line.split()
    call = parse(find(verb), words)
    assert list(call.names) == names
    assert dict(call.options) == options


@pytest.mark.parametrize(
    "line",
    [
        "kill",
        "kill a -s",
        "kill a -s NONSENSE",
        "kill a -s 0x9",
        "kill a -x",
        "kill a -NONSENSE",
        "stop a -9",
        "logs -n many",
        "logs -n -1",
        "logs --follow=yes",
        "send a",
        "send",
        "quit now",
        "top -p 0",
        "top -p nan",
    ],
)
def test_invalid_words_are_reported_with_the_usage_or_the_choices(line: str):
    verb, *words = line.split()
    with pytest.raises(UsageError) as error:
        parse(find(verb), words)
    assert error.value.hint or error.value.message.startswith(("-", verb))


@pytest.mark.parametrize(
    ("line", "message", "hint"),
    [
        ("kill robot -99", "unknown signal '99'", "known: SIGHUP"),
        ("kill robot -s SIGUSR9", "unknown signal 'SIGUSR9'", "known: SIGHUP"),
        ("kill robot -s SIGTREM", "unknown signal 'SIGTREM'", "did you mean 'SIGTERM'?"),
        ("kill robot -s kil", "unknown signal 'kil'", "did you mean 'SIGKILL'?"),
        ("stop -dash", "unknown option '-dash'", "an argument that begins with '-' goes behind --"),
        ("top -n 3", "unknown option '-n'", "usage: top [NAME ...]"),
        ("logs -n -3", "-n: '-3' is not a whole number of at least 0", ""),
        ("top -p 0", "-p: '0' is not a number of seconds above 0", ""),
        ("top -p nan", "-p: 'nan' is not a number of seconds", ""),
    ],
)
def test_a_mistake_is_reported_in_the_words_that_were_typed(line: str, message: str, hint: str):
    name, *words = line.split()
    with pytest.raises(UsageError) as error:
        parse(find(name), words)
    assert error.value.message == message
    assert hint in (error.value.hint or "")


def test_signal_0_may_be_written_as_a_flag():
    assert parse(find("kill"), ["robot", "-0"]).options == {"signal": 0}


def test_every_verb_says_how_it_is_written_and_options_are_in_it():
    for verb in VERBS:
        assert verb.usage.split()[0] == verb.name
        assert verb.help[0].islower()
        assert not verb.help.endswith(".")


@pytest.mark.parametrize(
    "line",
    [b"", b"{", b"[]", b'"a"', b"7", b"{}", b'{"verb": "ps", "names": {"a": 1}}', b"[" * 10**5],
)
def test_an_invalid_request_line_is_an_error(line: bytes):
    with pytest.raises(RequestError) as error:
        parse_request(line)
    assert error.value.cause.code == "bad-request"


@pytest.mark.parametrize("version", [0, 1, 3, "2", True, 2.5])
def test_another_version_is_no_request(version: object):
    with pytest.raises(RequestError) as error:
        parse_request(json.dumps({"verb": "ps", "id": 7, "protocol": version}).encode())
    assert (error.value.cause.code, error.value.id) == ("version", 7)


def test_what_is_unknown_in_a_request_is_ignored_for_later_versions():
    request = parse_request(b'{"verb": "ps", "colour": "red"}')
    assert (request.verb, request.names, request.options) == ("ps", (), {})


def test_what_is_json_already_is_handed_on_as_it_is():
    values = ['{"a": "\\u00e9"}', '{"b": "\\""}']
    reply = json.loads(raw_reply("x", "events", values))
    assert reply["result"]["events"] == [{"a": "é"}, {"b": '"'}]
    assert reply["text"] == values
    assert json.loads(raw_item(None, values[1])) == {"id": None, "item": {"b": '"'}}


# ---- the folder


def test_the_folder_of_the_session_comes_first_and_a_foreign_one_is_passed_over(tmp_path: Path):
    uid = os.getuid()
    session = {"XDG_RUNTIME_DIR": str(tmp_path), "TMPDIR": "/tmp/x"}
    temporary = Path(f"/tmp/x/ros-launcher-{uid}")
    assert socket_directory.candidates(session, uid) == [tmp_path / "ros-launcher", temporary]
    gone = {**session, "XDG_RUNTIME_DIR": "/nowhere"}
    assert socket_directory.candidates(gone, uid) == [temporary]
    relative = {"XDG_RUNTIME_DIR": "here"}
    assert socket_directory.candidates(relative, uid) == [Path(f"/tmp/ros-launcher-{uid}")]
    assert len(socket_directory.candidates(session, uid + 1)) == 1  # it is not theirs


def test_a_folder_of_somebody_else_is_not_trusted(tmp_path: Path):
    tmp_path.chmod(0o700)
    assert socket_directory.problem_of(tmp_path, os.getuid()) is None
    assert "belongs to another user" in str(socket_directory.problem_of(tmp_path, os.getuid() + 1))


def test_all_reasons_for_having_no_socket_are_reported():
    with tempfile.TemporaryDirectory() as root:  # whose path is short
        long = Path(root) / ("x" * 100)
        long.mkdir()
        blocked = Path(root) / f"ros-launcher-{os.getuid()}"
        blocked.write_text("")
        env = {"XDG_RUNTIME_DIR": str(long), "TMPDIR": root}
        with pytest.raises(ControlError, match=r"too long.*; .*is not a directory"):
            socket_directory.prepare("1", env, os.getuid())


# ---- what is imported when


def test_the_server_imports_no_interactive_or_ros_module():
    script = (
        "import sys, launcher.control.control_service\n"
        "print(*sorted(sys.modules.keys() & {'rich', 'prompt_toolkit', 'asyncio', 'rclpy'}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.strip() == ""
