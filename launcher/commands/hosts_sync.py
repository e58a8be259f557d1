"""`hosts sync [HOST ...]`: bring the launcher and packages to other hosts."""

from __future__ import annotations

import os
import sys

from launcher.command_line import DEBUG, Command, Parsed, option
from launcher.commands.hosts_file import HOSTS, hosts_file
from launcher.errors import ExitCode, LauncherError, UsageError
from launcher.text import count, did_you_mean, escape

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from launcher.hosts.model import Host
    from launcher.hosts.sync.fleet_sync import Result
    from launcher.hosts.sync.host_sync import Options, Outcome
    from launcher.hosts.sync.packages import Brought

_MOST_CHANGES = 40  # lines of a dry run for a host


def _sync(parsed: Parsed) -> int:
    from launcher.hosts.sync.fleet_sync import FleetSync

    hosts = _hosts(parsed)
    fleet = FleetSync(_options(parsed), _say)
    if parsed.rollback:
        return _report(fleet.roll_back(hosts), dry_run=parsed.dry_run)
    brought = _brought(parsed)
    try:
        results = fleet.sync(hosts, brought)
    except KeyboardInterrupt:
        print("interrupted: hosts that are not done use what they used before", file=sys.stderr)
        raise
    return _report(results, dry_run=parsed.dry_run)


def _hosts(parsed: Parsed) -> list[Host]:
    """The hosts that were named, or all; LauncherError."""
    file = hosts_file(parsed)
    for name in parsed.host:
        if name not in file.hosts:
            known = f"hosts of {file.path}: {', '.join(file.hosts)}"
            hint = did_you_mean(name, file.hosts) or known
            raise UsageError(f"unknown host '{name}'", hint=hint)
    return [file.hosts[name] for name in dict.fromkeys(parsed.host or file.hosts)]


def _options(parsed: Parsed) -> Options:
    from launcher.hosts.sync import requirements
    from launcher.hosts.sync.host_sync import Options

    listed = None
    if not parsed.no_venv and not parsed.rollback:
        path = parsed.requirements
        listed = requirements.default() if path is None else requirements.read(path)
    folder = parsed.wheelhouse
    return Options(
        requirements=listed,
        wheelhouse=None if folder is None else os.path.abspath(os.path.expanduser(folder)),
        dry_run=parsed.dry_run,
        force=parsed.force,
    )


def _brought(parsed: Parsed) -> Brought:
    from launcher.hosts.sync.packages import collect
    from launcher.workspace import current

    brought = collect(current(), parsed.package)
    names = ", ".join(sorted(brought.packages)) or "none"
    print(f"packages: {names}", file=sys.stderr)
    for path, reason in brought.tree.left_out.items():
        print(escape(f"left out: {path}: {reason}"), file=sys.stderr)
    return brought


def _say(host: str, text: str) -> None:
    print(escape(f"{host}: {text}"), file=sys.stderr, flush=True)


def _report(results: Sequence[Result], *, dry_run: bool) -> int:
    errors = [result for result in results if isinstance(result, LauncherError)]
    for error in _joined(errors):
        print(error.render(), file=sys.stderr)
    for result in results:
        if not isinstance(result, LauncherError):
            print(escape(_line(result, dry_run=dry_run)))
            for change in result.changes[:_MOST_CHANGES]:
                print(escape(f"  {change}", keep=""))
            if len(result.changes) > _MOST_CHANGES:
                print(f"  ... and {count(len(result.changes) - _MOST_CHANGES, 'change')} more")
    return ExitCode.PROCESS_FAILED if errors else ExitCode.OK


def _joined(errors: Sequence[LauncherError]) -> Iterator[LauncherError]:
    """With one error for all hosts on which the same is wrong."""
    from launcher.hosts.failures import HostError

    alike: dict[str, list[LauncherError]] = {}
    for error in errors:
        key = error.cause if isinstance(error, HostError) else error.render()
        alike.setdefault(key, []).append(error)
    for first, *others in alike.values():
        same = [one.host.name for one in (first, *others) if isinstance(one, HostError)]
        if others and isinstance(first, HostError):
            text = first.message.removeprefix(f"host '{same[0]}': ")
            yield LauncherError(f"hosts {', '.join(same)}: {text}", hint=first.hint)
        else:
            yield first


def _line(done: Outcome, *, dry_run: bool) -> str:
    head = f"{done.host}: "
    if done.before is not None:
        would = "would go back" if dry_run else "went back"
        return f"{head}{would} from {done.before} to {done.release}"
    if not done.is_changed:
        return f"{head}unchanged, {done.release} ({done.seconds:.1f} s)"
    size = _size(done.sent_bytes)
    if dry_run:
        return f"{head}would send {count(done.sent_files, 'file')}, {size}"
    parts = [f"{done.sent_files} of {count(done.files, 'file')} sent, {size}"]
    if done.environment_s is not None:
        parts.append(f"environment made in {done.environment_s:.0f} s")
    return f"{head}{done.release}: {'; '.join(parts)} ({done.seconds:.1f} s)"


def _size(number: int) -> str:
    return f"{number / 1e6:.1f} MB" if number >= 100_000 else f"{number / 1e3:.1f} kB"


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
        option("--dry-run", "show what would be done"),
        option("--force", "send all files and make the environment again"),
        DEBUG,
    ),
    exclusive=(("rollback", "force"), ("no_venv", "requirements"), ("no_venv", "wheelhouse")),
    epilog="exit codes: 0 all hosts are done, 1 one is not, 2 bad command line or hosts file",
    run=_sync,
)
