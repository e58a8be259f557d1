"""Collects facts about discovery on this machine: settings, multicast, clock, running nodes."""

from __future__ import annotations

import contextlib
import ctypes
import os
import socket
from collections.abc import Iterator, Mapping
from typing import Any

from launcher.doctor.doctor_facts import NetworkFacts, ParticipantProcess
from launcher.hosts.check.probe import GROUP, SETTINGS, addresses
from launcher.posix import proc
from launcher.posix.crowd import PROFILES
from launcher.posix.ports import announcement_ports, participants_by_domain
from launcher.ros.discovery.gids import holders
from launcher.run.monitor import shared_memory

_BACK_S = 0.2  # a datagram to the own group comes back at once
_LAST_PORT = 65535
_NOT_IN_STEP = 5  # TIME_ERROR of adjtimex(2)


def collect_network(env: Mapping[str, str]) -> NetworkFacts:
    """Without changing anything, and without a node."""
    return NetworkFacts(
        settings={name: env[name] for name in SETTINGS if env.get(name)},
        unknown_peers=tuple(_unknown_peers(env.get("ROS_STATIC_PEERS", ""))),
        unknown_servers=tuple(_unknown_servers(env.get("ROS_DISCOVERY_SERVER", ""))),
        loopback_fault=_loopback_fault(),
        without_multicast=tuple(one for one in addresses() if not _comes_back(one)),
        addresses=tuple(addresses()),
        is_in_step=_is_in_step(),
        nodes=tuple(_nodes()),
    )


def _unknown_peers(text: str) -> Iterator[str]:
    for name in filter(None, text.split(";")):
        try:
            socket.getaddrinfo(name, None)
        except OSError:
            yield name


def _unknown_servers(text: str) -> Iterator[str]:
    """Entries `HOST` or `HOST:PORT`, of which some may be empty; others are not judged."""
    for entry in filter(None, text.split(";")):
        if entry.count(":") > 1 or "[" in entry:
            continue
        host, _, port = entry.partition(":")
        try:
            socket.getaddrinfo(host, None)
        except OSError:
            yield entry
            continue
        if port and not (port.isdecimal() and int(port) <= _LAST_PORT):
            yield entry


def _loopback_fault() -> str | None:
    """Why a datagram from this machine to itself does not arrive; None if it does."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.settimeout(_BACK_S)
        try:
            own.bind(("127.0.0.1", 0))
            own.sendto(b"", own.getsockname())
            own.recv(1)
        except TimeoutError:
            return "datagrams do not arrive"
        except OSError as error:
            return str(error.strerror)
    return None


def _comes_back(address: str) -> bool:
    """Whether a datagram to DDS's group, sent on the interface of this address, arrives here."""
    own = socket.inet_aton(address)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        receiver.bind(("", 0))
        receiver.settimeout(_BACK_S)
        text = os.urandom(16)
        try:
            member = socket.inet_aton(GROUP) + own
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, own)
            sender.sendto(text, (GROUP, receiver.getsockname()[1]))
            return receiver.recv(64) == text
        except OSError:
            return False


def _is_in_step() -> bool | None:
    """Whether a time service keeps the clock; None if the kernel does not say."""
    with contextlib.suppress(OSError, AttributeError):
        state = ctypes.CDLL(None).adjtimex(ctypes.create_string_buffer(512))
        return None if state < 0 else bool(state != _NOT_IN_STEP)
    return None


def _nodes() -> Iterator[ParticipantProcess]:
    """Processes in this network that hold the ports of participants; others need root."""
    own_memory = _device(os.getpid())
    for domain in sorted(participants_by_domain()):
        for pid in sorted(holders(set(announcement_ports(domain)), set())):
            memory = _device(proc.living_thread(pid))
            found = details(pid, "cmdline", "environ")
            words, variables = found.get("cmdline") or [""], found.get("environ") or {}
            yield ParticipantProcess(
                pid=pid,
                command=os.path.basename(words[0]) or "?",
                domain=domain,
                settings={
                    name: variables[name] for name in (*SETTINGS, *PROFILES) if variables.get(name)
                },
                shares_memory=None if memory is None else memory == own_memory,
            )


def details(pid: int, *names: str) -> dict[str, Any]:
    """As `proc.details`; empty without psutil, whose absence is a finding."""
    try:
        return proc.details(pid, *names)
    except ImportError:
        return {}


def _device(pid: int) -> int | None:
    """The file system that /dev/shm is for a process; None if it cannot be seen."""
    try:
        return os.stat(f"{proc.ROOT}/{pid}/root{shared_memory.FOLDER}").st_dev
    except OSError:
        return None
