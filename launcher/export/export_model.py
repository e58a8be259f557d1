"""What is exported, as plain data: processes with their commands, and what cannot be exported."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.model.record import Record
from launcher.base.model.spec import Limits, RestartPolicy, StopPolicy
from launcher.hosts.file.hosts_model import LOCAL, Host

NO_HOST = LOCAL  # the name for processes that no rule places on a host


class LauncherPython(Record):
    """The Python interpreter with the launcher."""


class FileOf(Record):
    """A file that is written beside the exported ones, by its name in `Process.files`."""

    name: str


class Scratch(Record):
    """A separate folder to which the process may write."""


Part = str | LauncherPython | FileOf | Scratch
Word = tuple[Part, ...]  # joined without anything in between


class ExportedProcess(Record):
    """One process.

    `unit` is its name for systemd (`robot_1`), `name` the same as a DNS label (`robot-1`); both are
    unique in the export. `host` is None without a rule of placement. `environment` is written,
    variables in `private` are only named: their values may be secret. `node` is the full name of
    its ROS node, None if the launch file gives none, `package` that of its executable. `delay_s` is
    the time of its start.
    """

    unit: str
    name: str
    label: str
    host: Host | None
    words: tuple[Word, ...]
    files: Mapping[str, bytes] = {}
    environment: Mapping[str, str] = {}
    unset: tuple[str, ...] = ()
    private: tuple[str, ...] = ()
    cwd: str | None = None
    shell: bool = False
    tty: bool = False
    node: str | None = None
    package: str | None = None
    is_node: bool = True
    delay_s: float = 0.0
    restart: RestartPolicy = RestartPolicy()
    stop: StopPolicy = StopPolicy()
    limits: Limits = Limits()
    place: str = "the launch file"

    @property
    def host_name(self) -> str:
        return NO_HOST if self.host is None else self.host.name


class Unsupported(Record):
    """Something of the launch file that the exported files do not do.

    `what` is its name as in the launch file, `names` the processes that it is about. With `is_note`
    nothing is lost that the processes could notice.
    """

    what: str
    place: str
    text: str
    names: tuple[str, ...] = ()
    is_note: bool = False

    @property
    def line(self) -> str:
        about = f" ({', '.join(self.names)})" if self.names else ""
        return f"{self.place}: {self.what}{about}: {self.text}"


class ExportedSystem(Record):
    """All that a launch file starts at once or by timers, in the order of the starts."""

    name: str
    unit: str
    processes: tuple[ExportedProcess, ...]
    command: str
    gaps: tuple[Unsupported, ...] = ()

    @property
    def packages(self) -> list[str]:
        """The ROS packages of the processes."""
        return sorted({one.package for one in self.processes if one.package is not None})

    @property
    def hosts(self) -> dict[str, list[ExportedProcess]]:
        """Processes by the name of their host, in order."""
        found: dict[str, list[ExportedProcess]] = {}
        for process in self.processes:
            found.setdefault(process.host_name, []).append(process)
        return found

    @property
    def has_hosts(self) -> bool:
        """Whether a process is placed on a host; the others are then those of NO_HOST."""
        return any(process.host is not None for process in self.processes)

    def path_of(self, host: str, name: str) -> str:
        """A file of a host: in the folder of the host, unless there is no host."""
        return f"{host}/{name}" if self.has_hosts else name


class ExportedFiles(Record):
    """What an exporter returns: texts by path, and what its engine cannot do."""

    files: Mapping[str, str]
    gaps: tuple[Unsupported, ...] = ()
