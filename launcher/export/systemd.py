"""Units of systemd: a folder per host, with a service for each process and a target for all."""

from __future__ import annotations

import posixpath
import shlex
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from launcher.base.model.spec import StopPolicy
from launcher.export.export_model import ExportedFiles, ExportedProcess, ExportedSystem, Scratch
from launcher.export.exported_system import gaps_of_each
from launcher.export.process_command import Where, words_of
from launcher.hosts import unit
from launcher.hosts.file.hosts_model import DEFAULT_PYTHON
from launcher.hosts.ssh import SYNCED_PYTHON

if TYPE_CHECKING:
    from launcher.hosts.file.hosts_model import Host

_HOME = "HOME-OF-THE-USER-OF-THE-UNIT"  # until the words are quoted
_RUN_OF_USER = "RUNTIME-FOLDER-OF-THE-USER"  # likewise
_ROOT = "root"
_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


class Systemd:
    """Writes the units of a system.

    `user` and `python` are those of processes whose host is not in the hosts file, or has no such
    entry; without a user they are root's. `home`: the units are for the service manager of the user
    whose home that is.
    """

    ending = "service"

    def __init__(
        self,
        system: ExportedSystem,
        *,
        user: str | None = None,
        python: str = "python3",
        home: str | None = None,
    ) -> None:
        self._home = home
        self._system = system
        self._user = user
        self._python = python

    def output(self) -> ExportedFiles:
        files = {
            self._system.path_of(host, name): text
            for host, processes in self._system.hosts.items()
            for name, text in self._of_host(processes)
        }
        gaps = gaps_of_each(self._system.processes, self._gaps)
        return ExportedFiles(files=files, gaps=tuple(gaps))

    def _of_host(self, processes: Sequence[ExportedProcess]) -> Iterator[tuple[str, str]]:
        """The target, timers, files of processes, and a unit for each process."""
        yield f"{self._system.unit}.target", self._target()
        for process in processes:
            if process.delay_s:
                yield f"{process.unit}.timer", self._timer(process)
            for name, content in process.files.items():
                yield f"files/{name}", content.decode(errors="surrogateescape")
        private = sorted({name for process in processes for name in process.private})
        if private:
            yield f"{self._system.unit}.env.example", _example(private)
        for process in processes:
            yield f"{process.unit}.{self.ending}", self._service(process)

    # ---- units

    @property
    def folder(self) -> str:
        """Where files for the units are on a host."""
        base = "/etc" if self._home is None else f"{self._home}/.config"
        return f"{base}/launcher/{self._system.unit}"

    @property
    def _network(self) -> list[tuple[str, str]]:
        """The manager of a user does not know when the network is there."""
        return _NETWORK if self._home is None else []

    def _target(self) -> str:
        boot = "multi-user.target" if self._home is None else "default.target"
        return unit_text(
            ("Unit", [("Description", f"all processes of {self._system.unit}"), *self._network]),
            ("Install", [("WantedBy", boot)]),
        )

    def _timer(self, process: ExportedProcess) -> str:
        """Elapses once, so many seconds after the target was started."""
        about = f"start of {process.unit} after {process.delay_s:g} s"
        delay = unit.seconds(process.delay_s)
        return unit_text(
            ("Unit", [("Description", unit.literal(about)), *self._part_of()]),
            ("Timer", [("OnActiveSec", delay), ("AccuracySec", "100ms")]),
            ("Install", [("WantedBy", f"{self._system.unit}.target")]),
        )

    def _service(self, process: ExportedProcess) -> str:
        known, _ = unit.supported(
            unit.process_settings(process.restart, process.stop, process.limits), unit.OLDEST
        )
        of_unit = [(one.key, one.value) for one in known if one.section == "Unit"]
        of_service = [(one.key, one.value) for one in known if one.section == "Service"]
        return unit_text(
            ("Unit", [*self._unit_entries(process), *of_unit]),
            ("Service", [*self._runs(process), *of_service]),
            ("Install", self._install_entries(process)),
        )

    def _unit_entries(self, process: ExportedProcess) -> list[tuple[str, str]]:
        about = unit.literal(f"{process.label} of {self._system.unit}")
        return [("Description", about), *self._part_of(), *self._network]

    def _install_entries(self, process: ExportedProcess) -> list[tuple[str, str]]:
        """Empty for a process that a timer starts."""
        return [] if process.delay_s else [("WantedBy", f"{self._system.unit}.target")]

    def _part_of(self) -> list[tuple[str, str]]:
        return [("PartOf", f"{self._system.unit}.target")]

    def _runs(self, process: ExportedProcess) -> Iterator[tuple[str, str]]:
        yield "Type", "exec"
        if self._home is None:
            yield "User", unit.literal(self._user_of(process.host))
        yield "WorkingDirectory", unit.literal(process.cwd) if process.cwd else "~"
        for name, value in process.environment.items():
            yield "Environment", unit.exec_line([f"{name}={value}"])
        yield "Environment", "PYTHONUNBUFFERED=1"
        if process.private:
            yield "EnvironmentFile", f"{self.folder}/{self._system.unit}.env"
        if process.unset:
            yield "UnsetEnvironment", unit.exec_line(process.unset)
        if any(isinstance(part, Scratch) for word in process.words for part in word):
            yield "RuntimeDirectory", _runtime_directory(process)
            yield "RuntimeDirectoryMode", "0700"
        yield "ExecStart", self._command(process)

    def _user_of(self, host: Host | None) -> str:
        return (host.user if host else None) or self._user or _ROOT

    def _command(self, process: ExportedProcess) -> str:
        python = _in_home(python_of(process.host) if process.host else self._python)
        runtime = "/run" if self._home is None else _RUN_OF_USER
        where = Where(
            python=python,
            folder=f"{self.folder}/files",
            scratch=f"{runtime}/{_runtime_directory(process)}",
        )
        words = words_of(process, where)
        if "/" in python and "/" not in words[0]:
            # A program of the interpreter's environment.
            words = ["/usr/bin/env", f"PATH={posixpath.dirname(python)}:{_PATH}", *words]
        setup = process.host.setup if process.host else ()
        if setup:
            sourced = " && ".join(f". {_for_shell(path)}" for path in setup)
            words = ["/bin/sh", "-c", f'{sourced} && exec "$@"', "sh", *words]
        elif not words[0].startswith("/"):
            words = ["/usr/bin/env", *words]
        line = unit.exec_line(words).replace(_HOME, "${HOME}")
        return line.replace(_RUN_OF_USER, "${XDG_RUNTIME_DIR}")

    # ---- what is lost

    def _gaps(self, process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
        if process.tty:
            text = "the process has no terminal; Python's output is unbuffered nevertheless"
            yield "emulate_tty", text, True
        yield from policy_gaps(process)
        if self._user_of(process.host) == _ROOT and not (process.host and process.host.user):
            yield "user", "it runs as root: no user is named in the hosts file or by --user", True


def policy_gaps(process: ExportedProcess) -> Iterator[tuple[str, str, bool]]:
    """What systemd does otherwise when it restarts and stops the process.

    Not that ROS 2's SIGTERM is left out: the README describes that in general.
    """
    for text in unit.unmet(process.restart, StopPolicy(), unit.OLDEST):
        if "is left out" not in text:
            yield "restart", text, "random part" in text
    if process.stop.polite is not None and len(process.stop.polite) > 1:
        yield "stop", "after its first signal SIGKILL follows at once", True


_NETWORK = [("Wants", "network-online.target"), ("After", "network-online.target")]


def unit_text(*sections: tuple[str, Sequence[tuple[str, str]]]) -> str:
    parts = []
    for title, entries in sections:
        if entries:
            parts.append("\n".join([f"[{title}]", *(f"{k}={v}" for k, v in entries), ""]))
    return "\n".join(parts)


def _runtime_directory(process: ExportedProcess) -> str:
    return f"launcher-{process.unit}"


def python_of(host: Host) -> str:
    """The interpreter that the hosts file names, else that which `hosts sync` brings."""
    if host.python != DEFAULT_PYTHON:
        return host.python
    return f"{host.workspace.rstrip('/')}/{SYNCED_PYTHON}"


def _in_home(python: str) -> str:
    """The interpreter as an absolute path, or as a name that is looked up."""
    if "/" not in python or posixpath.isabs(python):
        return python
    return f"{_HOME}/{python.removeprefix('~/')}"


def _for_shell(path: str) -> str:
    """The path as a word of a shell script, relative to the home."""
    if posixpath.isabs(path):
        return shlex.quote(path)
    return f'"$HOME"/{shlex.quote(path.removeprefix("~/"))}'


def _example(names: Sequence[str]) -> str:
    head = "# Fill in the values, and keep this file from other users: chmod 600.\n"
    return head + "".join(f"{name}=\n" for name in names)
