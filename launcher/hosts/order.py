"""What a host is told to run: the specification of a process, independent of the machine.

A launch file is evaluated on the operator's machine, and its command lines have paths of this
machine. In an order they are references that the host resolves: the executable of a package, a
file in the share folder of a package, the content of a file that exists only here.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping

from launcher.model.record import Record
from launcher.model.spec import Limits, ProcessSpec, RestartPolicy, StopPolicy

MAX_FILE_BYTES = 1024 * 1024  # of a file that is sent with an order
# Variables that tell where software is on the operator's machine, or belong to its session.
_OF_THIS_MACHINE = frozenset(
    [
        "AMENT_PREFIX_PATH",
        "CMAKE_PREFIX_PATH",
        "COLCON_PREFIX_PATH",
        "HOME",
        "LD_LIBRARY_PATH",
        "LOGNAME",
        "OLDPWD",
        "PATH",
        "PWD",
        "PYTHONHOME",
        "PYTHONPATH",
        "ROS_LOG_DIR",
        "ROS_HOME",
        "SHELL",
        "SHLVL",
        "TERM",
        "TMPDIR",
        "USER",
        "VIRTUAL_ENV",
        "XDG_RUNTIME_DIR",
        "_",
    ]
)
# Variables of the operator's own environment that nodes elsewhere need, too.
_PASSED_ON = ("ROS_", "RMW_", "RCUTILS_", "RCL_", "FASTDDS_", "FASTRTPS_", "CYCLONEDDS_")


class Executable(Record):
    """The executable of a package."""

    package: str
    name: str


class SharedFile(Record):
    """A file in the share folder of a package; `path` is relative to it."""

    package: str
    path: str


class SentFile(Record):
    """A file that is sent with the order, by its name in `Order.files`."""

    name: str


class Interpreter(Record):
    """The Python interpreter of the launcher there."""


Part = str | Executable | SharedFile | SentFile | Interpreter
Word = tuple[Part, ...]  # joined without anything in between


class Order(Record):
    """One process for a host: what it runs, with which environment and policies.

    `environment` are the variables that the process gets besides those of the host, which may be
    secret; `unset` those that it must not have. `files` are contents by name.
    """

    name: str
    label: str
    words: tuple[Word, ...]
    environment: Mapping[str, str]
    unset: tuple[str, ...] = ()
    files: Mapping[str, bytes] = {}
    cwd: str | None = None
    shell: bool = False
    emulate_tty: bool = False
    merge: bool = False
    restart: RestartPolicy = RestartPolicy()
    stop: StopPolicy = StopPolicy()
    limits: Limits | None = None

    @property
    def executables(self) -> tuple[Executable, ...]:
        return tuple(p for word in self.words for p in word if isinstance(p, Executable))


def order_for(
    spec: ProcessSpec,
    *,
    base: Mapping[str, str],
    environment: Mapping[str, str] | None = None,
    merge: bool = False,
) -> Order:
    """The order for a process; `base` is the operator's environment, of which `spec.env` is a
    variant, and `environment` what the hosts file adds. LaunchFileError names what cannot be sent.
    """
    writer = _Writer(spec)
    words = tuple(writer.word(index, word) for index, word in enumerate(spec.argv))
    passed = {k: v for k, v in base.items() if k.startswith(_PASSED_ON)}
    changed = {k: v for k, v in spec.env.items() if base.get(k) != v}
    sent = {k: v for k, v in {**passed, **changed}.items() if k not in _OF_THIS_MACHINE}
    kept = {name: value for name, value in sent.items() if name in spec.env}
    return Order(
        name=spec.name,
        label=spec.label,
        words=words,
        environment={**kept, **(environment or {})},
        unset=tuple(sorted(base.keys() - spec.env.keys() - _OF_THIS_MACHINE)),
        files=writer.files,
        cwd=spec.cwd,
        shell=spec.shell,
        emulate_tty=spec.emulate_tty,
        merge=merge,
        restart=spec.restart,
        stop=spec.stop,
        limits=spec.limits,
    )


class _Writer:
    """Makes words, and collects the files that they need."""

    def __init__(self, spec: ProcessSpec) -> None:
        self._spec = spec
        self.files: dict[str, bytes] = {}

    def word(self, index: int, text: str) -> Word:
        ros = self._spec.ros
        if ros is not None and ros.package and ros.executable and index == self._program_index():
            return (Executable(ros.package, ros.executable),)
        if text in (sys.executable, os.path.realpath(sys.executable)):
            return (Interpreter(),)
        before, separator, path = text.rpartition(":=")
        reference = self._reference(path)
        return (text,) if reference is None else (f"{before}{separator}", reference)

    def _program_index(self) -> int:
        """Words before it are those of `prefix=`."""
        executable = self._spec.ros.executable if self._spec.ros else None
        names = [os.path.basename(word) for word in self._spec.argv]
        return names.index(executable) if executable in names else 0

    def _reference(self, path: str) -> SharedFile | SentFile | None:
        if not os.path.isabs(path) or not os.path.isfile(path):
            return None
        head, share, tail = path.partition("/share/")
        package, slash, rest = tail.partition("/")
        if share and slash and os.path.isdir(f"{head}/share/ament_index"):
            return SharedFile(package, rest)
        return self._send(path)

    def _send(self, path: str) -> SentFile | None:
        if os.access(path, os.X_OK) or os.path.getsize(path) > MAX_FILE_BYTES:
            return None
        with open(path, "rb") as file:
            content = file.read()
        name = unused_name(os.path.basename(path), content, self.files)
        self.files[name] = content
        return SentFile(name)


def unused_name(name: str, content: bytes, taken: Mapping[str, bytes]) -> str:
    """The name, with a number if another file has it."""
    stem, dot, suffix = name.rpartition(".") if "." in name[1:] else (name, "", "")
    candidates: Iterable[str] = (f"{stem}-{n}{dot}{suffix}" for n in range(2, len(taken) + 3))
    for candidate in (name, *candidates):
        if taken.get(candidate, content) == content:
            return candidate
    raise AssertionError  # there is one more candidate than names
