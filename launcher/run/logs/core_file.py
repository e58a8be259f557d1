"""The core file of a process that a signal has ended: where it is, and how to open it.

Read only after such an exit, and before a restart: so the modules are imported that each case
needs. See core(5) for the pattern of the names, and elf(5) for the notes in a core file that name
its process.
"""

from __future__ import annotations

import os
import re
import signal

from launcher.base.model.record import Record
from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator

    from launcher.base.model.events import Outcome
    from launcher.run.processes.process import Process

# Signals whose default action is a core dump (signal(7)).
SIGNALS = frozenset(
    getattr(signal, f"SIG{name}")
    for name in ("QUIT", "ILL", "TRAP", "ABRT", "BUS", "FPE", "SEGV", "XCPU", "XFSZ", "SYS")
)
_MAX_FILES = 20  # of those that the pattern fits, the newest are looked at
_CLOCK_S = 2.0  # some file systems round times so far
_WORD_64 = 2  # EI_CLASS of a 64-bit file
_NOTE, _PSINFO, _FILES = 4, 3, 0x46494C45  # PT_NOTE, NT_PRPSINFO, NT_FILE


class CorePattern(Record):
    """What the kernel does with a core dump: /proc/sys/kernel/core_pattern, core_uses_pid."""

    text: str
    uses_pid: bool = False

    @classmethod
    def of_kernel(cls) -> CorePattern:
        text = os.fsdecode(proc.read("sys", "kernel/core_pattern")).rstrip("\n")
        return cls(text, proc.read("sys", "kernel/core_uses_pid").strip() not in (b"", b"0"))

    @property
    def handler(self) -> str:
        """The program that gets core dumps; empty if they become files."""
        return self.text[1:].strip().partition(" ")[0] if self.text.startswith("|") else ""

    def glob(self, folder: str) -> str:
        """What fits the names of core files of processes in this working directory."""
        import glob

        parts = re.split("(%.?)", self.text)
        known = {"%%": "%", "%": ""}
        words = [known.get(part, "*") if part[:1] == "%" else glob.escape(part) for part in parts]
        end = ".*" if self.uses_pid and "%p" not in parts else ""
        return os.path.join(glob.escape(folder), "".join(words) + end)


class CoreFile(Record):
    """A core file; `session` is that of the process, `program` the path of its executable."""

    path: str
    session: int
    program: str


def note_of(process: Process, session: int, outcome: Outcome) -> str:
    """Where the core file is and how to open it, or how to get one; empty if there is none.

    A shell that led the session passes on the signal of its command as 128 + N.
    """
    code = outcome.returncode or 0
    if (-code if code < 0 else code - 128) not in SIGNALS:
        return ""
    pattern, is_own = CorePattern.of_kernel(), code < 0
    if is_own and not outcome.core_dumped:
        return _why_none(process, pattern)
    if pattern.handler:
        return _with_handler(pattern.handler, session) if is_own else ""
    folder = os.path.abspath(process.spec.cwd or os.getcwd())
    core = find(pattern.glob(folder), session, process.begun_wall_s)
    if core is not None:
        return _how_to_open(core)
    text = f"its core file was not found: the pattern of the kernel is '{pattern.text}'"
    return f"{text}, and it was started in {folder}" if is_own else ""


def find(names: str, session: int, since_s: float) -> CoreFile | None:
    """The newest core file of this session among those that fit, none older than `since_s`."""
    import glob

    dated = []
    for path in glob.iglob(names):
        try:
            dated.append((os.stat(path).st_mtime, path))
        except OSError:
            continue
    for written_s, path in sorted(dated, reverse=True)[:_MAX_FILES]:
        core = read(path) if written_s >= since_s - _CLOCK_S else None
        if core is not None and core.session == session:
            return core
    return None


def read(path: str) -> CoreFile | None:
    """The facts in a core file; None if it is none, or cannot be read."""
    import struct

    try:
        with open(path, "rb") as file:
            notes = dict(_notes(file.read(1 << 20)))
    except (OSError, struct.error):
        return None
    info = notes.get(_PSINFO, b"")
    if len(info) < 40:
        return None
    (session,) = struct.unpack_from("i", info, 36)
    return CoreFile(path, session, _first_file(notes.get(_FILES, b"")))


def _notes(data: bytes) -> Iterator[tuple[int, bytes]]:
    """(type, content) of each note; the kernel writes them before the memory."""
    if data[:5] != bytes([0x7F, *b"ELF", _WORD_64]):
        return
    import struct

    (at,) = struct.unpack_from("Q", data, 32)
    size, number = struct.unpack_from("HH", data, 54)
    for place in range(at, at + size * number, size):
        kind, _, start, _, _, length = struct.unpack_from("IIQQQQ", data, place)
        end = min(start + length, len(data)) if kind == _NOTE else 0
        while start + 12 <= end:
            name, content, note = struct.unpack_from("III", data, start)
            start += 12 + _padded(name)
            yield note, data[start : start + content]
            start += _padded(content)


def _padded(size: int) -> int:
    return (size + 3) & ~3


def _first_file(note: bytes) -> str:
    """The first of the mapped files, which is the program: it has the lowest address."""
    if len(note) < 16:
        return ""
    import struct

    (number,) = struct.unpack_from("Q", note)
    return os.fsdecode(note[16 + 24 * number :].partition(b"\0")[0])


def _how_to_open(core: CoreFile) -> str:
    import shlex

    path = shlex.quote(core.path)
    text = f"core file: {core.path}; to open it: gdb {shlex.quote(core.program)} {path}"
    if os.path.basename(core.program).startswith("python"):
        text += f", or for the Python stack: py-spy dump --core {path}"
    return text


def _with_handler(handler: str, pid: int) -> str:
    """The kernel has passed the core dump to a program."""
    name = os.path.basename(handler)
    where = "" if os.path.exists(handler) else " on the host of this container"
    if name == "systemd-coredump":
        return f"core dump: to open it{where}: coredumpctl debug {pid}"
    if name == "apport":
        command = "apport-unpack /var/crash/FILE.crash DIR, then gdb PROGRAM DIR/CoreDump"
        return f"core dump: apport writes it to /var/crash{where}; to open it: {command}"
    return f"core dump: the kernel has passed it to {handler}{where}"


def _why_none(process: Process, pattern: CorePattern) -> str:
    if not pattern.handler and _limit_of(process) == 0:
        import shlex

        limit = shlex.quote(f"{process.spec.label}:core=unlimited")
        return (
            f"it left no core file, since their size is limited to 0; to get one: --limit {limit}"
        )
    if pattern.handler:
        return f"it left no core dump: the kernel passes them to {pattern.handler}, which failed"
    return f"it left no core file: '{pattern.text}' could not be written"


def _limit_of(process: Process) -> int:
    limits = process.spec.limits
    given = {} if limits is None else {name: soft for name, soft, _ in limits.rlimits}
    if "core" in given:
        return given["core"]
    import resource

    return resource.getrlimit(resource.RLIMIT_CORE)[0]
