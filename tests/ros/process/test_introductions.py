"""New participants are introduced to those that run already; the ports are all there is of them."""

from __future__ import annotations

import contextlib
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.posix.ports import multicast_port
from launcher.ros.discovery import rtps
from launcher.ros.discovery.endpoints import contact_in
from launcher.ros.discovery.introductions import introduction
from tests.support.ros_domain import ros_domain
from tests.support.verbs import Answer, launcher

NOBODY = bytes(rtps.PREFIX_BYTES)
FILE = """from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([Node(executable="{script}", name="late")])
"""
# Takes the ports of the second and then of the third participant, each until it is introduced: that
# of the other one may come once more meanwhile.
NODE = """#!{python}
import socket, time
time.sleep(0.2)
kept = []
for port in ({port}, {port} + 2):
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
    kept += sockets
    for number, one in enumerate(sockets):
        one.bind(("127.0.0.1", port + number))
    sockets[0].settimeout({wait_s})
    try:
        while port.to_bytes(4, "little") not in sockets[0].recv(2000):
            pass
    except TimeoutError:
        break
"""


@pytest.fixture
def env(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path) as env:
        yield env


@contextlib.contextmanager
def participant(env: dict[str, str]) -> Iterator[socket.socket]:
    """The ports of the first participant of the domain; the socket for announcements."""
    first = multicast_port(int(env["ROS_DOMAIN_ID"])) + 10
    with contextlib.ExitStack() as stack:
        new = [
            stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2)
        ]
        for number, one in enumerate(new):
            one.bind(("127.0.0.1", first + number))
        yield new[0]


def run_late(env: dict[str, str], tmp_path: Path, wait_s: float, *options: str) -> Answer:
    port = multicast_port(int(env["ROS_DOMAIN_ID"])) + 12
    script = tmp_path / "late"
    script.write_text(NODE.format(python=sys.executable, port=port, wait_s=wait_s))
    script.chmod(0o755)
    file = tmp_path / "late.launch.py"
    file.write_text(FILE.format(script=script))
    return launcher(
        {**env, "LAUNCHER_CONTROL": "0"}, str(file), "--cold", "--no-domain-check", *options
    )


def received(ports: socket.socket) -> list[rtps.Data]:
    """What has arrived, by now."""
    ports.setblocking(False)
    found = []
    with contextlib.suppress(BlockingIOError):
        while True:
            found += rtps.parts(ports.recv(2000), NOBODY)
    return [one for one in found if isinstance(one, rtps.Data)]


def test_new_participants_of_a_process_are_announced_with_their_addresses_and_disposed_of(
    env, tmp_path
):
    port = multicast_port(int(env["ROS_DOMAIN_ID"])) + 12
    with participant(env) as ports:
        assert run_late(env, tmp_path, 20.0).code == 0
        samples = received(ports)
    announced = [one for one in samples if not one.gone]
    assert announced
    assert {contact_in(one.payload)[0] for one in announced} == {port, port + 2}
    assert {one.writer for one in samples if one.gone} == {one.writer for one in announced}


@pytest.mark.parametrize(
    ("options", "variables"),
    [
        (["--no-introductions"], {}),
        ([], {"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"}),
        ([], {"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}),
        ([], {"FASTRTPS_DEFAULT_PROFILES_FILE": "/dev/null"}),
    ],
    ids=["option", "server", "rmw", "profiles"],
)
def test_nobody_is_introduced(env, tmp_path, options: list[str], variables: dict[str, str]):
    with participant(env) as ports:
        assert run_late({**env, **variables}, tmp_path, 0.5, *options).code == 0
        assert received(ports) == []


def test_an_introduction_requests_answers_and_nothing_else():
    begun, ended = introduction([7412, 7414])
    (announced,) = rtps.parts(begun, NOBODY)
    assert isinstance(announced, rtps.Data)
    assert contact_in(announced.payload) == (7412, 7412, 1 << 1)
    listed = rtps.parameters(announced.payload)[1]
    addresses = [value for number, value in listed if number == 0x32]
    assert addresses == [rtps.locator("127.0.0.1", port) for port in (7412, 7414)]
    assert not any(number == 0x2C for number, _ in listed)  # user data names the enclave
    (end,) = rtps.parts(ended, NOBODY)
    assert isinstance(end, rtps.Data)
    assert end.gone
    assert end.key == announced.writer[: rtps.PREFIX_BYTES] + rtps.PARTICIPANT
