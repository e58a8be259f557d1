"""What `hosts sync` prints about each host, when that host is done."""

from __future__ import annotations

import sys

from launcher.base.errors import ExitCode, LauncherError
from launcher.base.text import count, escape

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from launcher.hosts.file.hosts_model import Host
    from launcher.hosts.sync.fleet_sync import Result
    from launcher.hosts.sync.host_sync import EnvironmentPlan, SyncOutcome

_MOST_CHANGES = 40  # lines of a dry run for a host
_REPEAT = "a release is used only when it is complete: repeat the command"


class SyncReport:
    """Errors are printed at the end, identical ones once.

    `rollback` says that the command does something else when it is repeated.
    """

    def __init__(self, hosts: Sequence[Host], *, dry_run: bool, rollback: bool = False) -> None:
        self._names = [host.name for host in hosts]
        self._open = [*self._names]
        self._dry_run = dry_run
        self._rollback = rollback
        self._errors: dict[str, LauncherError] = {}

    def add(self, host: Host, result: Result) -> None:
        """A host is done."""
        self._open.remove(host.name)
        if not isinstance(result, LauncherError):
            self._print(result)
            return
        self._errors[host.name] = result
        if self._open:
            print(f"{host.name}: failed, see below", file=sys.stderr, flush=True)

    def end(self) -> int:
        """All are done; the exit code."""
        self._print_errors()
        return ExitCode.PROCESS_FAILED if self._errors else ExitCode.OK

    def interrupt(self) -> None:
        """The others will not be done."""
        self._print_errors()
        if self._open:
            hint = "" if self._dry_run or self._rollback else f" ({_REPEAT})"
            text = f"interrupted; not done: {', '.join(self._open)}{hint}"
            print(text, file=sys.stderr, flush=True)

    def _print(self, done: SyncOutcome) -> None:
        lines = [escape(_line(done, dry_run=self._dry_run))]
        if done.environment is not None:
            lines.append(escape(f"  environment: {_planned(done.environment)}"))
        lines += [escape(f"  {change}", keep="") for change in done.changes[:_MOST_CHANGES]]
        if len(done.changes) > _MOST_CHANGES:
            lines.append(f"  ... and {count(len(done.changes) - _MOST_CHANGES, 'change')} more")
        print("\n".join(lines), flush=True)

    def _print_errors(self) -> None:
        errors = [self._errors[name] for name in self._names if name in self._errors]
        for error in joined(errors):
            print(error.render(), file=sys.stderr)


def joined(errors: Sequence[LauncherError]) -> Iterator[LauncherError]:
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


def _line(done: SyncOutcome, *, dry_run: bool) -> str:
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


def _planned(plan: EnvironmentPlan) -> str:
    if plan.wheels is None:
        return "would be made by pip there"
    of = f"would be made of {count(plan.wheels, 'wheel')}, {plan.sent} of them sent"
    if not plan.missing:
        return f"{of}, {_size(plan.sent_bytes)}"
    return f"{of}, after the download of {plan.missing} into {plan.folder}"


def _size(number: int) -> str:
    return f"{number / 1e6:.1f} MB" if number >= 100_000 else f"{number / 1e3:.1f} kB"
