"""Command lines of processes for other supervisors."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.model.record import Record
from launcher.base.model.spec import UNLIMITED, Limits
from launcher.export.export_model import ExportedProcess, FileOf, LauncherPython, Part, Scratch

PYTHON_IN_IMAGE = "python3"
FOLDER_IN_IMAGE = "/etc/launcher/files"
_SCRATCH_IN_IMAGE = "/tmp/launcher"
# Ends at once when it is stopped, also as the first process of a container.
WAIT = "trap 'exit 0' INT TERM; sleep {0} & wait $!"


class Where(Record):
    """What the references of a command are where it will run."""

    python: str
    folder: str
    scratch: str

    def text(self, part: Part) -> str:
        match part:
            case FileOf(name=name):
                return f"{self.folder}/{name}"
            case LauncherPython():
                return self.python
            case Scratch():
                return self.scratch
            case _:
                return part


_IN_IMAGE = Where(python=PYTHON_IN_IMAGE, folder=FOLDER_IN_IMAGE, scratch=_SCRATCH_IN_IMAGE)


def words_of(process: ExportedProcess, where: Where) -> list[str]:
    """The command as it is executed."""
    words = ["".join(map(where.text, word)) for word in process.words]
    return ["/bin/sh", "-c", " ".join(words)] if process.shell else words


def in_container(process: ExportedProcess, limits: Limits) -> list[str]:
    """The command in a container; `limits` are those for which its engine has no setting."""
    return [*_limiting(limits), *words_of(process, _IN_IMAGE)]


def _limiting(limits: Limits) -> Iterator[str]:
    """Words in front of a command, of coreutils and util-linux."""
    if limits.nice is not None:
        yield from ("nice", "-n", str(limits.nice))
    if limits.cpus is not None:
        yield from ("taskset", "-c", cpu_list(limits.cpus))
    if limits.rlimits:
        yield "prlimit"
        yield from (f"--{n}={_amount(soft)}:{_amount(hard)}" for n, soft, hard in limits.rlimits)


# Resources that container engines limit by themselves, as `--ulimit` does.
_NAMES = (
    "core cpu data fsize locks memlock msgqueue nofile nproc rss rtprio rttime sigpending stack"
)
_ULIMITS = frozenset(_NAMES.split())


def ulimits(limits: Limits) -> list[tuple[str, int, int]]:
    return [one for one in limits.rlimits if one[0] in _ULIMITS]


def without_settings(limits: Limits) -> Limits:
    """The limits that are neither `ulimits` nor processors."""
    rest = tuple(one for one in limits.rlimits if one[0] not in _ULIMITS)
    return Limits(nice=limits.nice, rlimits=rest)


def cpu_list(cpus: tuple[int, ...]) -> str:
    return ",".join(map(str, cpus))


def _amount(amount: int) -> str:
    return "unlimited" if amount == UNLIMITED else str(amount)


def after(delay_s: float, words: list[str]) -> list[str]:
    """The command, started so many seconds later."""
    if not delay_s:
        return words
    return ["/bin/sh", "-c", f'{WAIT.format(f"{delay_s:g}")} && exec "$@"', "sh", *words]
