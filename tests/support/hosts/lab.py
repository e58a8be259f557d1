"""A laboratory: an operator and hosts on one bridge, on this machine only."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import yaml

from tests.support.hosts import leftovers
from tests.support.hosts.host import Host
from tests.support.hosts.keys import make_key
from tests.support.hosts.network import Network
from tests.support.hosts.operator import Operator
from tests.support.hosts.robot import Robot
from tests.support.hosts.sockets import SSH_PORT

AnyHost = TypeVar("AnyHost", Host, Robot)


class Lab:
    """Use `with`: all that was made is removed in the end."""

    def __init__(self) -> None:
        leftovers.remove_leftovers()
        self.name = leftovers.new_name()
        self.folder = leftovers.STATE / self.name
        self._computers: list[Operator | Host | Robot] = []
        self.hosts: dict[str, Host | Robot] = {}
        self._trusting = threading.Lock()

    def __enter__(self) -> Lab:
        try:
            self.folder.mkdir(mode=0o755, parents=True)
            self.key = self.folder / "key"
            self.public_key = make_key(self.key)
            self.known_hosts = self.folder / "known_hosts"
            self.known_hosts.touch()
            self.network = Network(self.name)
            self.operator = Operator(self.network.add_operator(), self.folder / "operator")
            self._computers.append(self.operator)
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Remove everything, even what a test has left half made."""
        leftovers.remove(self.name)
        for computer in self._computers:
            computer.close()

    def host(
        self,
        name: str,
        *,
        multicast: bool = True,
        routed: bool = False,
        clock_offset_s: float = 0.0,
    ) -> Host:
        """Start a host, which the operator knows by its key.

        `multicast=False`: no multicast reaches it, or leaves it. `routed`: it has a subnet of its
        own. `clock_offset_s`: its clock is ahead of the machine's.
        """
        port = self.network.add(name, multicast=multicast, routed=routed)
        folder = self.folder / name
        return self._add(Host(name, port, folder, self.public_key, clock_offset_s=clock_offset_s))

    def robot(self, name: str, *, multicast: bool = True, routed: bool = False) -> Robot:
        """Start a robot with systemd, which the operator knows by its key; see `host`."""
        port = self.network.add(name, multicast=multicast, routed=routed)
        return self._add(Robot(name, port, self.folder / name, self.public_key))

    def _add(self, host: AnyHost) -> AnyHost:
        self._computers.append(host)
        self.hosts[host.name] = host
        self.trust(host)
        return host

    def trust(self, host: Host | Robot) -> None:
        """Add the key of a host to known_hosts, in place of others of its address."""
        with self._trusting:
            lines = self.known_hosts.read_text(encoding="ascii").splitlines(keepends=True)
            others = [line for line in lines if not line.startswith(f"{host.address} ")]
            new = f"{host.address} {host.public_key}\n"
            self.known_hosts.write_text("".join([*others, new]), encoding="ascii")

    def ssh_options(self) -> dict[str, Any]:
        """Options of ssh_config(5) with which the operator logs in to a host."""
        return {
            "Port": SSH_PORT,
            "IdentityFile": str(self.key),
            "UserKnownHostsFile": str(self.known_hosts),
        }

    def ssh(self, host: Host | Robot, *words: str, user: str = "root") -> list[str]:
        """The words of an ssh command for the operator, with strict checks and no questions."""
        strict = {"BatchMode": "yes", "StrictHostKeyChecking": "yes", "IdentitiesOnly": "yes"}
        options = {**self.ssh_options(), **strict}
        pairs = [word for name, value in options.items() for word in ("-o", f"{name}={value}")]
        return ["ssh", *pairs, f"{user}@{host.address}", *words]

    def hosts_file(
        self,
        path: Path,
        hosts: Iterable[Host | Robot] | Mapping[Host | Robot, Mapping[str, Any]],
        place: Mapping[str, str],
        **top_level: Any,
    ) -> Path:
        """Write a hosts file; a mapping gives further settings of each host, or changes them."""
        extra = hosts if isinstance(hosts, Mapping) else {host: {} for host in hosts}
        table = {host.name: {**self.settings(host), **extra[host]} for host in extra}
        content = {"hosts": table, "place": dict(place), **top_level}
        path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        return path

    def settings(self, host: Host | Robot) -> dict[str, Any]:
        """What a hosts file says about a host."""
        return {
            "address": host.address,
            "user": host.user,
            "python": sys.executable,
            "ssh": self.ssh_options(),
        }
