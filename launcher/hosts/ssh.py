"""The command lines of OpenSSH for a host.

Everything that the shell there reads is quoted. No value of the environment is in a command line:
what is secret goes through standard input.
"""

from __future__ import annotations

import os
import posixpath
import shlex
from collections.abc import Iterable, Mapping, Sequence

from launcher.base.errors import UsageError
from launcher.hosts import ciphers
from launcher.hosts.file.hosts_model import DEFAULT_PYTHON, Host
from launcher.posix import socket_directory

CONNECT_TIMEOUT_S = 10
# A link that is down for less than their product does not end a session.
ALIVE_INTERVAL_S = 5
ALIVE_COUNT = 6
SYNCED_PYTHON = "current/bin/python"  # in the workspace of a host
# Beside it: the interpreter with which `hosts sync` has made it, and the one that was named then.
MADE_WITH = ".python"
_SOCKET_RESERVE = 17  # characters that ssh adds to the path of its socket for a while
_SOCKET_SUFFIX = ".ssh"

# Ours in any case: nobody can answer a question, and forwarding is of no use.
_FORCED = (
    "BatchMode=yes",
    "ClearAllForwardings=yes",
    "EscapeChar=none",
    "RemoteCommand=none",
    "RequestTTY=no",
)
# The hosts file may say otherwise. Interactive traffic gets a low delay on wifi, too.
_DEFAULTS = (
    "StrictHostKeyChecking=yes",
    f"ConnectTimeout={CONNECT_TIMEOUT_S}",
    f"ServerAliveInterval={ALIVE_INTERVAL_S}",
    f"ServerAliveCountMax={ALIVE_COUNT}",
    "Compression=no",
    "IPQoS=af21",
    "ForwardAgent=no",
    "ForwardX11=no",
    "PermitLocalCommand=no",
    "LogLevel=INFO",
)


class SshConnection:
    """The ways to one host. Its sessions share the connection of `leader`, while that runs.

    `control_path` is its socket (`new_control_path`); None: the sessions use a connection that the
    user's configuration of ssh names, if it is open. UsageError if an option cannot be given to
    ssh.
    """

    def __init__(self, host: Host, control_path: str | None) -> None:
        self.host = host
        self.control_path = control_path
        self._options = [*_FORCED, *_own(host), *_DEFAULTS]

    @property
    def destination(self) -> str:
        """`robot@10.0.0.2`."""
        return f"{self.host.user}@{self.host.address}" if self.host.user else self.host.address

    def session(self, command: str) -> list[str]:
        """Run a script of the POSIX shell there; without a leader it connects on its own."""
        return self._ssh(["ControlMaster=no"], [posix_shell(command)])

    def leader(self, command: str) -> list[str]:
        """As `session`, and the sessions that come later share its connection."""
        return self._ssh(["ControlMaster=auto"], [posix_shell(command)])

    def alone(self, command: str) -> list[str]:
        """As `session`, but on a separate connection: a shared one may be lost."""
        return self._ssh(["ControlMaster=no"], [posix_shell(command)], shared=False)

    def _ssh(
        self, options: Sequence[str], command: Sequence[str], *, shared: bool = True
    ) -> list[str]:
        return [*self._base(options, shared=shared), "--", self.destination, *command]

    def _base(self, options: Sequence[str], *, shared: bool = True) -> list[str]:
        path = "none" if not shared else self.control_path and _literal(self.control_path)
        control = [] if path is None else [f"ControlPath={path}"]
        cipher = ciphers.preferred()
        chosen = [] if cipher is None else [f"Ciphers={cipher}"]
        # Of two values for an option, ssh takes the first.
        all_options = [*self._options, *chosen, *control, *options, "ControlPersist=no"]
        return ["ssh", "-T", *(word for option in all_options for word in ("-o", option))]


def quoted(words: Iterable[str]) -> str:
    """Words for a POSIX shell."""
    return " ".join(map(shlex.quote, words))


def posix_shell(script: str) -> str:
    """What runs this script of the POSIX shell in any login shell (fish, csh), too."""
    return f"exec sh -c {shlex.quote(script)}"


def setup_script(host: Host) -> str:
    """Goes to the user's home and reads the setup files of the host; a command may follow.

    What a setup file prints goes to standard error: standard output belongs to a protocol.
    """
    files = [f". {shlex.quote(in_home(path))} >&2; " for path in host.setup]
    return "cd || exit; " + "".join(files)


def python_script(host: Host, words: Sequence[str]) -> str:
    """`cd || exit; . setup.sh; exec python3 WORDS`, quoted, with the Python of `set_python`."""
    return f'{setup_script(host)}{set_python(host)}exec "$python" {quoted(words)}'


def set_python(host: Host) -> str:
    """Sets `python`, in the home: that which `hosts sync` brought, else that of the hosts file.

    One that the hosts file names wins if the other was not made with it, and it is there, or has
    been named since.
    """
    own = shlex.quote(host_python(host))
    synced = in_home(f"{host.workspace.rstrip('/')}/{SYNCED_PYTHON}")
    script = f'python={shlex.quote(synced)}; test -x "$python" || python={own}; '
    if host.python == DEFAULT_PYTHON:
        return script
    made_with = shlex.quote(posixpath.join(posixpath.dirname(synced), MADE_WITH))
    return (
        f"{script}made=; named=; "
        f"{{ {{ IFS= read -r made; IFS= read -r named; }} < {made_with}; }} 2>/dev/null; "
        f'test "$made" = {own} || {{ ! command -v {own} >/dev/null && '
        f'{{ test -z "$named" || test "$named" = {own}; }}; }} || python={own}; '
    )


def host_python(host: Host) -> str:
    """The interpreter, for a shell in the user's home."""
    return in_home(host.python) if "/" in host.python else host.python


def in_home(path: str) -> str:
    """For a shell in the home, whose quotes prevent its meaning of `~`."""
    relative = path.removeprefix("~/")
    return relative if os.path.isabs(relative) else f"./{relative}"


def ssh_environment(base: Mapping[str, str]) -> dict[str, str]:
    """The environment of ssh: messages in English, which `failure` can read."""
    env = {name: value for name, value in base.items() if name not in ("LC_ALL", "LANGUAGE")}
    if base.get("LC_ALL"):
        env["LANG"] = base["LC_ALL"]
    return {**env, "LC_MESSAGES": "C"}


def new_control_path(env: Mapping[str, str]) -> str:
    """Where the socket of a leader may be, which ssh removes at its end; ControlError.

    Removes sockets whose launcher and ssh were killed.
    """
    name = f"{os.getpid()}-{os.urandom(6).hex()}"
    try:
        path = socket_directory.prepare(name, env, os.getuid(), reserve=_SOCKET_RESERVE)
    except socket_directory.ControlError:  # XDG_RUNTIME_DIR and TMPDIR may be too long
        path = socket_directory.prepare(name, {}, os.getuid(), reserve=_SOCKET_RESERVE)
    for abandoned in socket_directory.abandoned(path.parent, _SOCKET_SUFFIX):
        abandoned.unlink(missing_ok=True)
    return str(path.with_suffix(_SOCKET_SUFFIX))


def _literal(path: str) -> str:
    """A path as a value of ssh_config, where `%` begins a token and a blank ends a word."""
    escaped = path.replace("%", "%%").replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _own(host: Host) -> list[str]:
    """The options of the hosts file, as `Name=value`."""
    for name, value in host.ssh.items():
        if not name.isalnum() or any(ord(c) < 32 for c in str(value)):
            raise UsageError(
                f"host '{host.name}': '{name}' cannot be given to ssh",
                hint="options of ssh are names of ssh_config(5) with a value of one line",
                where=host.where or None,
            )
    return [f"{name}={value}" for name, value in host.ssh.items()]
