"""What the two ends of the link refuse: other programs and versions, malformed frames."""

from __future__ import annotations

import contextlib
import os
import random
import subprocess
import sys

import pytest

from launcher.hosts.engine.frames import (
    CLOCK_SAMPLES,
    HEADER,
    MAX_PAYLOAD,
    PREAMBLE,
    PROTOCOL,
    FrameKind,
    encode,
    pack,
)
from launcher.hosts.engine.link import LinkState
from launcher.hosts.file import order_json
from tests.support.link_recorder import AGENT, Recorder, python
from tests.support.repository import REPOSITORY

pytestmark = pytest.mark.usefixtures("patient")

# ---- what cannot serve


def refusal_of(script: str) -> tuple[LinkState, str]:
    with Recorder(words=("sh", "-c", script, "sh")) as recorder:
        recorder.until(lambda: recorder.states, "an answer")
        return recorder.states[0]


def test_a_host_without_the_launcher_is_told():
    state, reason = refusal_of(
        f"unset PYTHONPATH; cd /; exec {sys.executable} -I -S -m launcher agent"
    )

    assert state is LinkState.UNREACHABLE
    assert "launcher" in reason


def test_an_agent_of_another_version_is_told_with_both():
    hello = {"protocol": PROTOCOL + 1, "version": "9.9.9", "received": 0}
    data = PREAMBLE + encode(FrameKind.HELLO, 0, 0.0, pack(hello))
    octal = "".join(f"\\{byte:03o}" for byte in data)

    state, reason = refusal_of(f"printf '{octal}'; cat >/dev/null")

    assert state is LinkState.GONE
    assert "9.9.9" in reason
    assert "hosts sync" in reason


NO_AGENT = "head -c 200000 /dev/zero; echo 'not an agent' >&2; exit 3"


def test_what_is_no_agent_is_told():
    assert refusal_of(NO_AGENT) == (LinkState.UNREACHABLE, "not an agent")


def test_what_is_no_agent_is_told_if_its_end_is_noticed_before_its_output():
    with Recorder(words=("sh", "-c", NO_AGENT, "sh")) as recorder:
        channel = recorder.link._channel
        recorder.until(lambda: channel.is_attached, "its start")
        recorder.reactor.remove(channel._read_fd)  # epoll may tell of several in any order
        recorder.until(lambda: recorder.states, "an answer")
        assert recorder.states == [(LinkState.UNREACHABLE, "not an agent")]


# ---- the agent obeys frames only


def talk(data: bytes) -> subprocess.CompletedProcess[bytes]:
    """Send this to an agent, and close its input."""
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    return subprocess.run(AGENT, input=data, capture_output=True, timeout=60, env=env, check=False)


def opening(stop_after_s: float | None) -> bytes:
    about = {"protocol": PROTOCOL, "version": "x", "key": "1-a", "received": 0}
    return encode(FrameKind.OPEN, 0, 1.0, pack({**about, "stop_after_s": stop_after_s}))


OPEN = opening(0)
MALFORMED = {
    "no frame": b"GET / HTTP/1.1\r\n\r\n" + b"x" * 100,
    "too long": OPEN + HEADER.pack(MAX_PAYLOAD + 1, FrameKind.PREPARE, 1, 0.0),
    "no JSON": OPEN + encode(FrameKind.PREPARE, 1, 1.0, b"{" * 50),
    "no order": OPEN
    + encode(FrameKind.PREPARE, 1, 1.0, pack({"id": 1, "order": {"name": "s3cr3t"}})),
    "unknown process": OPEN
    + encode(FrameKind.COMMAND, 1, 1.0, pack({"id": 7, "command": "START"})),
    "no request": OPEN + encode(FrameKind.COMMAND, 1, 1.0, pack({"id": 7, "command": "STARTED"})),
    "no signal": OPEN + encode(FrameKind.SIGNAL, 1, 1.0, pack({"id": 1, "signal": 999})),
    "a report": OPEN + encode(FrameKind.OUTPUT, 1, 1.0, b"\0\0\0\1\0text"),
    "before the first": encode(FrameKind.FINISH, 1, 1.0, pack({"at_once": True})),
    "another protocol": encode(FrameKind.OPEN, 0, 1.0, pack({"protocol": PROTOCOL + 1})),
}


@pytest.mark.parametrize("data", MALFORMED.values(), ids=MALFORMED)
def test_malformed_requests_end_the_agent_with_a_message(data: bytes):
    found = talk(data)

    assert found.returncode == 1
    assert found.stdout.startswith(PREAMBLE)
    assert b"Traceback" not in found.stderr
    assert b"s3cr3t" not in found.stderr + found.stdout


def test_a_malformed_request_is_in_the_exit_code_if_nobody_reads_the_message():
    ours, full = os.pipe()
    os.set_blocking(full, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(full, b"x" * 4096)
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    try:
        data = MALFORMED["no signal"]
        found = subprocess.run(AGENT, input=data, stdout=full, timeout=60, env=env, check=False)
    finally:
        os.close(ours)
        os.close(full)
    assert found.returncode == 1


def test_input_that_ends_before_the_first_frame_ends_the_agent():
    assert talk(b"").returncode == 1
    assert talk(OPEN[:9]).returncode == 1


def test_a_launcher_that_leaves_while_it_connects_is_not_waited_for():
    """It waits for one whose processes it keeps for ten minutes."""
    beat = encode(FrameKind.BEAT, 0, 1.0)

    assert talk(opening(None) + beat * (CLOCK_SAMPLES - 1)).returncode == 1


def test_a_terminal_is_refused_with_an_explanation():
    ours, theirs = os.openpty()
    try:
        found = subprocess.run(
            AGENT, stdin=theirs, stdout=theirs, stderr=subprocess.PIPE, text=True, check=False
        )
    finally:
        os.close(ours)
        os.close(theirs)
    assert found.returncode == 2
    assert "not to a terminal" in found.stderr


def conversation() -> bytes:
    """A valid one that starts a process, and finishes."""
    order = order_json.encode(python("print('up')"))
    requests = [
        (FrameKind.PREPARE, {"id": 1, "order": order}),
        (FrameKind.COMMAND, {"id": 1, "command": "START"}),
        (FrameKind.SIGNAL, {"id": 1, "signal": 15, "by_user": True}),
        (FrameKind.FINISH, {"at_once": True}),
    ]
    frames = (encode(kind, n, 1.0, pack(content)) for n, (kind, content) in enumerate(requests, 1))
    return OPEN + b"".join(frames)


def damaged(data: bytes, chance: random.Random) -> bytes:
    """The same with some bytes changed, left out or added."""
    found = bytearray(data)
    for _ in range(chance.randint(1, 8)):
        place = chance.randrange(len(found))
        match chance.randrange(3):
            case 0:
                found[place] = chance.randrange(256)
            case 1:
                del found[place : place + chance.randint(1, 20)]
            case 2:
                found[place:place] = chance.randbytes(chance.randint(1, 20))
    return bytes(found)


@pytest.mark.thorough
def test_damaged_conversations_end_every_agent_in_order():
    chance = random.Random(7)
    env = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    agents = []
    for _ in range(24):
        agent = subprocess.Popen(
            AGENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env
        )
        assert agent.stdin is not None
        agent.stdin.write(damaged(conversation(), chance))
        agent.stdin.flush()
        agents.append(agent)
    for agent in agents:
        output, errors = agent.communicate(timeout=90)
        assert output.startswith(PREAMBLE)
        assert b"Traceback" not in errors, errors
        assert agent.returncode in (0, 1)
