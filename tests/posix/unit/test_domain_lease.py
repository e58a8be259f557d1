"""Leases of ROS domains: never two at once, and never a domain in use."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.posix import domain_lease
from launcher.posix.domain_lease import leased_domain
from launcher.posix.ports import busy_domains

LEASE = """
import sys
from launcher.posix import domain_lease
domain_lease._DOMAIN_IDS = range(int(sys.argv[1]), int(sys.argv[1]) + 1)
try:
    with domain_lease.leased_domain():
        print("got it")
except domain_lease.NoFreeDomainError as error:
    print(error)
"""


@pytest.fixture(autouse=True)
def _domains_of_our_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that no other test leases: one that is free again must stay so for a while."""
    monkeypatch.setattr(domain_lease, "_DOMAIN_IDS", range(1, 20))


def test_two_leases_have_different_domains():
    with leased_domain() as one, leased_domain() as two:
        assert one != two


def test_a_domain_with_an_open_port_is_busy():
    with leased_domain() as domain_id, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        assert domain_id not in busy_domains()
        taken.bind(("127.0.0.1", 7400 + 250 * domain_id + 10))
        assert domain_id in busy_domains()
    assert domain_id not in busy_domains()


def test_a_domain_that_is_not_accepted_is_not_held():
    refused: set[int] = set()
    with leased_domain(lambda domain_id: len(refused) == 3 or bool(refused.add(domain_id))) as one:
        assert len(refused) == 3
        assert one not in refused
        with contextlib.ExitStack() as stack:
            others = {stack.enter_context(leased_domain(refused.__contains__)) for _ in refused}
        assert others == refused


def leased_elsewhere(domain_id: int, folder: Path) -> str:
    """Output of a process that leases exactly this domain, with another temporary folder."""
    env = {**os.environ, "TMPDIR": str(folder), "XDG_RUNTIME_DIR": str(folder)}
    words = [sys.executable, "-c", LEASE, str(domain_id)]
    return subprocess.run(words, env=env, capture_output=True, text=True, check=True).stdout


def test_another_process_does_not_get_a_leased_domain_and_gets_it_afterwards(tmp_path: Path):
    with leased_domain() as domain_id:
        assert "in use on this machine" in leased_elsewhere(domain_id, tmp_path)
    assert leased_elsewhere(domain_id, tmp_path) == "got it\n"


def test_a_lease_is_not_handed_on_to_children(tmp_path: Path):
    with leased_domain() as domain_id:
        child = subprocess.Popen(["sleep", "1000"], close_fds=False)
    try:
        assert leased_elsewhere(domain_id, tmp_path) == "got it\n"
    finally:
        child.kill()
        child.wait()
