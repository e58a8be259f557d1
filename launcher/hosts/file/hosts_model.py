"""The hosts of a run and the rules that place processes on them, as plain data."""

from __future__ import annotations

import enum
from collections.abc import Mapping

from launcher.base.model.record import Record, replace

DEFAULT_PYTHON = "python3"
LOCAL = "local"  # the name of the machine on which the launcher runs, in rules of placement


class HostEngine(enum.Enum):
    """What starts and supervises the processes of a host.

    AUTO is SYSTEMD where the host has it, else SSH.
    """

    AUTO = "auto"
    SSH = "ssh"
    SYSTEMD = "systemd"


class LinkPolicy(Record):
    """What a host does with its processes while the operator cannot be reached.

    `stop_after_s` None: they run on (`keep`); else the host stops them after so many seconds.
    """

    stop_after_s: float | None = None


class Secret(Record):
    """Where the value of a variable comes from: a variable of the operator, or a file.

    One of the two is set; `file` is absolute.
    """

    variable: str | None = None
    file: str | None = None

    def __str__(self) -> str:
        return f"environment variable {self.variable}" if self.variable else f"file {self.file}"


class Host(Record):
    """One host of a hosts file.

    `ssh` are options of OpenSSH (`Port`, `IdentityFile`), by name. `python` is the interpreter with
    the launcher there, absolute or relative to the user's home; `setup` are files that a POSIX
    shell sources before it (`/opt/ros/jazzy/setup.sh`). `environment` are variables for the
    processes there, none of which may be shown; of those in `secrets` the value is not in the file.
    `on_link_loss` None is the default of the engine: SYSTEMD keeps, SSH stops after 10 s.
    `workspace` is the folder that `hosts sync` fills, relative to the home. `node_selector` are
    labels of a Kubernetes node. `is_skipped`: nothing is started there in this run. `where` is the
    place in the file, for messages.
    """

    name: str
    address: str
    user: str | None = None
    engine: HostEngine = HostEngine.AUTO
    ssh: Mapping[str, str] = {}
    python: str = DEFAULT_PYTHON
    setup: tuple[str, ...] = ()
    environment: Mapping[str, str] = {}
    secrets: Mapping[str, Secret] = {}
    on_link_loss: LinkPolicy | None = None
    workspace: str = ".local/share/launcher/workspace"
    node_selector: Mapping[str, str] = {}
    is_skipped: bool = False
    where: str = ""

    def __repr__(self) -> str:
        """Without values of variables, which may be secret."""
        return f"Host({self.name!r}, {self.address!r}, environment=<{', '.join(self.environment)}>)"


class Rule(Record):
    """`pattern: host` of a hosts file; `host` may be LOCAL.

    `where`, `source_line` and `column` (from 1) are its place in the file, for messages.
    """

    pattern: str
    host: str
    where: str = ""
    source_line: str | None = None
    column: int | None = None


class DiscoveryMode(enum.Enum):
    """How nodes on several hosts find each other."""

    MULTICAST = "multicast"
    PEERS = "peers"
    SERVER = "server"


class Discovery(Record):
    """Discovery of a run. `mode` None leaves the environment as it is.

    `server` and `backup` are hosts on which the discovery servers run, or LOCAL. `port` None is
    the usual one, or where the server is LOCAL, the next one that is free.
    """

    mode: DiscoveryMode | None = None
    server: str = LOCAL
    backup: str | None = None
    port: int | None = None
    where: str = ""

    def by(self, mode: str | None) -> Discovery:
        """In this way, if an option says so."""
        return self if mode is None else replace(self, mode=DiscoveryMode(mode), where="")


class HostsFile(Record):
    """A hosts file that was read: hosts by name, and the rules in the order of the file."""

    path: str
    hosts: Mapping[str, Host]
    rules: tuple[Rule, ...] = ()
    warnings: tuple[str, ...] = ()
    discovery: Discovery = Discovery()
