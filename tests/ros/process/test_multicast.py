"""`multicast send` and `receive`, in a network of their own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

LAUNCHER = (sys.executable, "-m", "launcher")
HOLD = """\
ip link set lo up multicast on &&
ip route add 224.0.0.0/4 dev lo src 127.0.0.1 &&
echo ready &&
exec cat
"""


@pytest.fixture
def network() -> Iterator[int]:
    """The id of a process in a new network, whose only interface takes multicast."""
    if os.geteuid() != 0 or not all(map(shutil.which, ("unshare", "nsenter", "ip"))):
        pytest.skip("needs root, unshare, nsenter and ip")
    with subprocess.Popen(
        ["unshare", "--net", "sh", "-c", HOLD],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as holder:
        try:
            assert holder.stdout is not None
            if holder.stdout.readline() != "ready\n":
                pytest.skip(f"no network of its own: {holder.communicate()[1]}")
            yield holder.pid
        finally:
            holder.kill()


def start(network: int, *words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        ["nsenter", f"--net=/proc/{network}/ns/net", *LAUNCHER, "multicast", *words],
        cwd=REPOSITORY,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


OWN = ["--group", "239.1.2.3", "--port", "50000"]


@pytest.mark.parametrize(
    ("options", "ttl"), [([], []), ([], ["--ttl", "255"]), (OWN, [])], ids=["plain", "ttl", "group"]
)
def test_a_packet_arrives_at_all_who_wait(network, options, ttl):
    waiting = [start(network, "receive", "--timeout", "60", *options) for _ in range(2)]

    def is_over() -> bool:
        sent = start(network, "send", *options, *ttl)
        assert sent.communicate(timeout=60) == ("Sending one UDP multicast datagram...\n", "")
        return all(process.poll() is not None for process in waiting)

    wait_until(is_over, "both have received a packet")
    for process in waiting:
        out, err = process.communicate(timeout=60)
        assert (err, process.returncode) == ("", 0)
        first, second = out.splitlines()
        assert first == "Waiting for UDP multicast datagram..."
        assert re.fullmatch(r"Received from 127\.0\.0\.1:\d+: 'Hello World!'", second), out


def test_without_a_packet_receive_fails_after_its_timeout(network):
    out, err = (process := start(network, "receive", "--timeout", "0.3")).communicate(timeout=60)
    assert out == "Waiting for UDP multicast datagram...\n"
    assert (err, process.returncode) == ("no packet arrived within 0.3 s\n", 1)


def test_a_network_without_multicast_is_named(network):
    route = ["ip", "route", "del", "224.0.0.0/4", "dev", "lo"]
    subprocess.run(["nsenter", f"--net=/proc/{network}/ns/net", *route], check=True)
    _, err = (process := start(network, "send")).communicate(timeout=60)
    assert err.startswith("nothing can be sent to 225.0.0.1:49150: Network is unreachable\nhint: ")
    assert process.returncode == 1
