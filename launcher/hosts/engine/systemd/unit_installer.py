"""Units that stay on a host: installs them, enabled for boot, and removes them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.hosts import unit
from launcher.hosts.engine.systemd.host_facts import HostFacts, hello, read_facts
from launcher.hosts.engine.systemd.scripts import written
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import SshConnection, quoted
from launcher.hosts.ssh_command import run

TIMEOUT_S = 60.0
LIST = "installed"  # the names of the units of a system, in its folder


def places(home: str | None) -> tuple[str, str]:
    """The folders of units and of what they need, of a user with this home or of the machine."""
    if home is None:
        return "/etc/systemd/system", "/etc/launcher"
    return f"{home}/.config/systemd/user", f"{home}/.config/launcher"


class Installer:
    """Talks to one host, once it is made; LauncherError with the host's name."""

    def __init__(self, host: Host) -> None:
        self._host = host
        self._connection = SshConnection(host, None)
        self.facts = self._ask()

    def _ask(self) -> HostFacts:
        answer = run(self._connection, hello(self._host), timeout_s=TIMEOUT_S).stdout
        try:
            facts = read_facts(answer.decode(errors="replace"))
        except (KeyError, ValueError):
            raise self._error("its shell does not answer as a POSIX shell does") from None
        if facts.version < unit.OLDEST or not facts.state:
            raise self._error(f"it has no systemd {unit.OLDEST} or newer that answers")
        return facts

    def _error(self, text: str, hint: str | None = None) -> LauncherError:
        return LauncherError(f"host '{self._host.name}': {text}", hint=hint)

    def install(
        self,
        name: str,
        files: Mapping[str, bytes],
        secrets: bytes,
        enabled: Sequence[str],
    ) -> None:
        """Replace the units of the system `name`, enable these, and start its target.

        The target starts all, each once: a short process may have ended when the next is started.
        `files` are units, and others below `files/`; `secrets` is the content of `NAME.env`.
        """
        facts = self.facts
        if facts.is_user and not facts.lingers:
            raise self._error(
                f"units of {facts.user} start when {facts.user} logs in, not at boot",
                f"there, as root: loginctl enable-linger {facts.user}",
            )
        units = [path for path in files if "/" not in path and "." in path]
        lines = ["umask 022", f"mkdir -p {self._units} {self._folder(name)}/files"]
        lines += [self._removal(name)]
        for path, content in files.items():
            place = self._raw_units if path in units else self._raw_folder(name)
            lines.append(_or_exit(written(f"{place}/{path}", content)))
        if secrets:
            path = f"{self._raw_folder(name)}/{name}.env"
            lines.append(_or_exit(f"(umask 077\n{written(path, secrets)})"))
        content = "".join(f"{one}\n" for one in units).encode()
        lines.append(_or_exit(written(f"{self._raw_folder(name)}/{LIST}", content)))
        ctl = self._systemctl
        start = f"{ctl} start {shlex.quote(f'{name}.target')}"
        enable = f"{ctl} daemon-reload && {ctl} enable --quiet {quoted(enabled)}"
        lines.append(_or_exit(f"{enable} && {start}"))
        fails = f'{ctl} is-failed --quiet "$one"'
        fail = '{ echo "$one has failed" >&2; exit 1; }'
        lines.append(f"for one in {quoted(enabled)}; do ! {fails} || {fail}; done")
        self._run("\n".join(lines))

    def remove(self, name: str) -> bool:
        """Stop and remove the units of the system; whether there were any."""
        folder = self._folder(name)
        done = self._run(
            f"[ -d {folder} ] || {{ echo none; exit 0; }}\n{self._removal(name)}\n"
            f'rm -rf {folder}\nrmdir "$(dirname {folder})" 2>/dev/null\n'
            f"{self._systemctl} daemon-reload"
        )
        return done.strip() != "none"

    def _removal(self, name: str) -> str:
        """Stops and removes what was installed before, which may have had other units."""
        return (
            f"if [ -f {self._folder(name)}/{LIST} ]; then while read -r one; do\n"
            f'  {self._systemctl} disable --now --quiet "$one" </dev/null\n'
            f'  {self._systemctl} reset-failed "$one" </dev/null 2>/dev/null\n'
            f'  rm -f {self._units}/"$one"\n'
            f"done <{self._folder(name)}/{LIST}; fi"
        )

    @property
    def _systemctl(self) -> str:
        if not self.facts.is_user:
            return "systemctl"
        return f"XDG_RUNTIME_DIR={shlex.quote(self.facts.runtime)} systemctl --user"

    @property
    def _places(self) -> tuple[str, str]:
        return places(self.facts.home if self.facts.is_user else None)

    @property
    def _raw_units(self) -> str:
        return self._places[0]

    @property
    def _units(self) -> str:
        return shlex.quote(self._raw_units)

    def _raw_folder(self, name: str) -> str:
        return f"{self._places[1]}/{name}"

    def _folder(self, name: str) -> str:
        return shlex.quote(self._raw_folder(name))

    def _run(self, script: str) -> str:
        """The script goes through standard input: it has secrets."""
        done = run(self._connection, "exec sh", data=script.encode(), timeout_s=TIMEOUT_S)
        if done.returncode:
            lines = done.stderr.decode(errors="replace").strip().splitlines()
            raise self._error(f"cannot install units: {lines[-1] if lines else done.returncode}")
        return done.stdout.decode(errors="replace")


def _or_exit(script: str) -> str:
    return f"{script}\n[ $? = 0 ] || exit 1"
