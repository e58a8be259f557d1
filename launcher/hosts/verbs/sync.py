"""`hosts sync [HOST ...]`: bring the launcher and packages to other hosts."""

from __future__ import annotations

import os
import sys

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import UsageError
from launcher.base.option import DEBUG, option
from launcher.base.text import did_you_mean, escape
from launcher.hosts.verbs.hosts_options import HOSTS, hosts_file
from launcher.hosts.verbs.sync_report import SyncReport

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.hosts.file.hosts_model import Host
    from launcher.hosts.sync.host_sync import SyncOptions
    from launcher.hosts.sync.synced_packages import Brought


def _sync(parsed: Parsed) -> int:
    from launcher.hosts.sync.fleet_sync import FleetSync

    hosts = _hosts(parsed)
    report = SyncReport(hosts, dry_run=parsed.dry_run, rollback=parsed.rollback)
    fleet = FleetSync(_options(parsed), _say, done=report.add)
    brought = None if parsed.rollback else _brought(parsed)
    try:
        if brought is None:
            fleet.roll_back(hosts)
        else:
            fleet.sync(hosts, brought)
    except KeyboardInterrupt:
        report.interrupt()
        raise
    except BrokenPipeError:
        report.end()  # nobody reads what was done, but all hosts are
        raise
    return report.end()


def _hosts(parsed: Parsed) -> list[Host]:
    """The hosts that were named, or all; LauncherError."""
    file = hosts_file(parsed)
    for name in parsed.host:
        if name not in file.hosts:
            known = f"hosts of {file.path}: {', '.join(file.hosts)}"
            hint = did_you_mean(name, file.hosts) or known
            raise UsageError(f"unknown host '{name}'", hint=hint)
    return [file.hosts[name] for name in dict.fromkeys(parsed.host or file.hosts)]


def _options(parsed: Parsed) -> SyncOptions:
    from launcher.hosts.sync import pinned_list
    from launcher.hosts.sync.host_sync import SyncOptions

    listed = None
    if not parsed.no_venv and not parsed.rollback:
        path = parsed.requirements
        listed = pinned_list.default() if path is None else pinned_list.read(path)
    return SyncOptions(
        requirements=listed,
        wheelhouse=_folder(parsed.wheelhouse),
        dry_run=parsed.dry_run,
        force=parsed.force,
    )


def _folder(given: str | None) -> str | None:
    """The folder that --wheelhouse names, which may be a new one; UsageError."""
    if given is None:
        return None
    path = os.path.abspath(os.path.expanduser(given))
    if os.path.lexists(path) and not os.path.isdir(path):
        hint = "name the folder of the wheels, or a new one: it is filled"
        raise UsageError(f"--wheelhouse: {given} is not a folder", hint=hint)
    return path


def _brought(parsed: Parsed) -> Brought:
    from launcher.hosts.sync.synced_packages import collect
    from launcher.packages.workspace import current

    brought = collect(current(), parsed.package)
    names = ", ".join(sorted(brought.packages)) or "none"
    print(f"packages: {names}", file=sys.stderr)
    for path, reason in brought.tree.left_out.items():
        print(escape(f"left out: {path}: {reason}"), file=sys.stderr)
    return brought


def _say(host: str, text: str) -> None:
    print(escape(f"{host}: {text}"), file=sys.stderr, flush=True)


SYNC = Command(
    "hosts sync",
    "bring the launcher, packages and their environment to hosts",
    arguments=(option("[HOST ...]", "by default all of the hosts file", default=()),),
    synopsis="[HOST ...] [options]",
    about="""\
Bring to each host, all at the same time, the launcher, the packages of the workspace as they are
built, those used from their source folder, and an environment of Python with the pinned packages.
Only what has changed is sent. A host uses the new release when it is complete, and keeps three.

A host with `setup` in the hosts file (an installation of ROS 2), or whose `python` is that of an
environment, gets no environment.""",
    options=(
        HOSTS,
        option(
            "--package NAME",
            "one more package whose source folder is found here; may be given several times",
            default=(),
            repeat="all",
        ),
        option("--requirements FILE", "list of packages with versions for the environments"),
        option(
            "--wheelhouse DIR",
            "folder of wheels from which environments are made without a network there; missing "
            "ones are downloaded into it",
        ),
        option("--no-venv", "make no environment: the host's Python has what is needed"),
        option("--rollback", "use the release again that was used before"),
        option("--dry-run", "show what would be done; write and download nothing"),
        option("--force", "send all files and make the environment again"),
        DEBUG,
    ),
    exclusive=(
        *(("rollback", name) for name in ("force", "package", "requirements", "wheelhouse")),
        ("rollback", "no_venv"),
        ("no_venv", "requirements"),
        ("no_venv", "wheelhouse"),
    ),
    epilog="exit codes: 0 all hosts are done, 1 one is not, 2 bad command line or hosts file",
    run=_sync,
)
