"""The command lines of OpenSSH for a host.

Everything that the shell there reads is quoted. No value of the environment is in a command line:
what is secret goes through standard input.
"""

from __future__ import annotations

import hashlib
import os
import posixpath
import shlex
from collections.abc import Iterable, Mapping, Sequence

from launcher.errors import UsageError
from launcher.hosts.model import DEFAULT_PYTHON, Host

CONNECT_TIMEOUT_S = 10
# A link that is down for less than their product does not end a session.
ALIVE_INTERVAL_S = 5
ALIVE_COUNT = 6
SYNCED_PYTHON = "current/bin/python"  # in the workspace of a host
# Beside it: the interpreter with which `hosts sync` has made it, and the one that was named then.
MADE_WITH = ".python"
_MAX_SOCKET = 107 - 17  # of the address of a Unix socket; ssh adds 17 characters for a while

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


class Connection:
    """The ways to one host. Its sessions share the connection of `leader`, while that runs.

    `control_folder` is a private folder (`private_folder`) for the socket of the leader; None: the
    sessions use a connection that the user's configuration of ssh names, if it is open. UsageError
    if the folder's path is too long for a socket, or if an option cannot be given to ssh.
    """

    def __init__(self, host: Host, control_folder: str | None) -> None:
        self.host = host
        self.control_path = None if control_folder is None else _socket(host, control_folder)
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
        """As `session`, but on a connection of its own: a shared one may be lost."""
        return self._ssh(["ControlMaster=no"], [posix_shell(command)], shared=False)

    def _ssh(
        self, options: Sequence[str], command: Sequence[str], *, shared: bool = True
    ) -> list[str]:
        return [*self._base(options, shared=shared), "--", self.destination, *command]

    def _base(self, options: Sequence[str], *, shared: bool = True) -> list[str]:
        path = "none" if not shared else self.control_path and _literal(self.control_path)
        control = [] if path is None else [f"ControlPath={path}"]
        # Of two values for an option, ssh takes the first.
        all_options = [*self._options, *control, *options, "ControlPersist=no"]
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


def private_folder() -> str:
    """Make a folder for sockets that only this user can enter; the caller removes it."""
    import tempfile

    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    usable = os.path.isdir(runtime) and os.access(runtime, os.W_OK) and len(runtime) < 40
    return tempfile.mkdtemp(prefix="launcher-ssh-", dir=runtime if usable else "/tmp")


def _socket(host: Host, folder: str) -> str:
    text = repr((host.name, host.address, host.user, sorted(host.ssh.items())))
    path = os.path.join(folder, hashlib.sha256(text.encode(errors="replace")).hexdigest()[:12])
    if len(os.fsencode(path)) > _MAX_SOCKET:
        raise UsageError(
            f"the path of the folder '{folder}' is too long for a socket of ssh",
            hint="set XDG_RUNTIME_DIR or TMPDIR to a folder with a shorter path",
        )
    return path


def _literal(path: str) -> str:
    """A path in a value of ssh_config, where `%` begins a token."""
    return path.replace("%", "%%")


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
