"""Who is asked by a check, without a host."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from launcher.base.model.level import Level
from launcher.hosts import discovery
from launcher.hosts.check import examine
from launcher.hosts.check.probe_session import ProbeSession, remote_command
from launcher.hosts.file.hosts_model import Discovery, DiscoveryMode, Host, HostsFile


def test_a_login_is_told_before_a_setup_file_fails(tmp_path: Path):
    host = Host(name="bot", address="10.0.0.2", setup=("none.sh",))

    done = subprocess.run(
        ["sh", "-c", remote_command(host)[-1]],
        env={"HOME": str(tmp_path), "PATH": "/usr/bin:/bin"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode != 0
    assert done.stdout.startswith("launcher-check-user ")


def test_a_name_that_is_not_resolved_in_time_delays_no_other(monkeypatch):
    is_over = threading.Event()

    def address_of(host: Host) -> str:
        if host.name == "slow":
            is_over.wait(60)
        return "127.0.0.1"

    monkeypatch.setattr(discovery, "address_of", address_of)
    hosts = [Host(name=name, address=f"{name}.invalid") for name in ("slow", "bot")]
    try:
        found, mistakes = examine._addresses(hosts, 3.0)
        assert found == {"bot": ("127.0.0.1", "127.0.0.1")}
        text = "the address 'slow.invalid' of slow was not resolved within 3 s"
        assert [(name, one.message) for name, one in mistakes.items()] == [("slow", text)]
    finally:
        is_over.set()


@pytest.mark.parametrize("mode", [DiscoveryMode.PEERS, DiscoveryMode.SERVER])
def test_a_name_that_cannot_be_resolved_is_a_problem_of_its_host(monkeypatch, mode: DiscoveryMode):
    monkeypatch.setattr(discovery, "ssh_host_name", lambda host: host.address)
    monkeypatch.setattr(ProbeSession, "start", _start_here)
    hosts = {name: Host(name=name, address=name) for name in ("localhost", "bot.invalid")}

    result = examine.examine(
        HostsFile(path="hosts.yaml", hosts=hosts), Discovery(mode=mode), {}, domain=7, timeout_s=60
    )

    (finding,) = [one for one in result.findings if "cannot be resolved" in one.text]
    assert (finding.check, finding.hosts) == ("discovery", ("bot.invalid",))
    assert finding.level is Level.PROBLEM
    assert "discovery needs an IPv4 address" in finding.advice


def _start_here(session: ProbeSession, request: Mapping[str, Any]) -> None:
    """Start the probe of a host as that of this machine."""
    host, session.host = session.host, None
    _start(session, request)
    session.host = host


_start = ProbeSession.start
