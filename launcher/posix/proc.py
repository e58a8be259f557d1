"""Reads /proc: state, command line and environment of processes, sockets.

Files are read with `os.open`, which takes a third of the time of `open()`: some callers read a file
of every process. For a process that has exited, or belongs to another user, the results are empty.

What looks at a few processes and is not a run takes `details`, which asks psutil. The rest is read
here, for what `python -m benchmarks process-table` measures: with psutil a launcher with ten idle
children takes 1.12 of the RSS, 1.14 of the PSS with its watchdog, and Python 4 times the CPU time
to start. The docstring of a reader has its CPU time for 40 processes as a part of psutil's. The
watchdog has no site-packages, and psutil takes a process for a zombie whose main thread has ended.
"""

from __future__ import annotations

import os

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from typing import Any

ROOT = "/proc"  # replaced by tests

# Indices into `stat_fields`, for fields 3, 4, 9, 14, 15, 20, 22, 24 and 26 of proc(5).
STATE, PARENT, FLAGS, USER_TICKS, SYSTEM_TICKS, THREADS = 0, 1, 6, 11, 12, 17
START_TICKS, RSS_PAGES, START_CODE = 19, 21, 23
# PF_EXITING and PF_KTHREAD of the kernel's linux/sched.h.
_EXITING, _KERNEL_THREAD = 0x4, 0x200000

_ENDED = (b"Z", b"X")
SUSPENDED = (b"T", b"t")  # by SIGSTOP or SIGTSTP, and by a debugger
_STATES = {
    "D": "uninterruptible sleep",
    "Z": "a zombie",
    "T": "stopped",
    "t": "traced",
    "R": "running",
    "S": "sleeping",
}
_BLOCK = 8192  # bytes; more than one block only for environments and tables of sockets


def read(pid: int | str, name: str) -> bytes:
    """Contents of /proc/PID/NAME; `pid` may be "self" or "net"; empty where it cannot be read."""
    try:
        fd = os.open(f"{ROOT}/{pid}/{name}", os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return b""
    content = b""
    try:
        while block := os.read(fd, _BLOCK):
            content += block
    except OSError:
        return b""  # it has just exited
    finally:
        os.close(fd)
    return content


def read_memory(pid: int, name: str) -> bytes:
    """As `read`, for a file about the memory of a process: `environ`, `cmdline`, `maps` ..."""
    content = read(pid, name)
    if not content and (tid := living_thread(pid)) != pid:
        return read(tid, name)
    return content


def pids() -> list[int]:
    """Every process in our pid namespace, zombies included; empty where there is no /proc."""
    try:
        return [int(name) for name in os.listdir(ROOT) if name.isdigit()]
    except OSError:
        return []


def mapped(pid: int) -> set[str]:
    """Paths of the files that it has mapped; behind that of a removed one is ` (deleted)`.

    0.06 of psutil's time, which reads the memory of each mapping, too.
    """
    lines = (line.split(None, 5) for line in read_memory(pid, "maps").splitlines())
    return {os.fsdecode(words[5]) for words in lines if len(words) == 6}


def uss_bytes(pid: int) -> int | None:
    """The memory that would be free if the process exited; None if it cannot be read.

    0.86 of psutil's time: the kernel walks all pages.
    """
    lines = [line.split() for line in read_memory(pid, "smaps_rollup").splitlines()]
    private = [int(line[1]) for line in lines if line[0].startswith(b"Private_")]
    return 1024 * sum(private) if private else None


def stat_fields(pid: int) -> list[bytes]:
    """Fields of /proc/PID/stat from the state on; empty if there is no such process.

    The command before them may contain blanks and parentheses.
    """
    return read(pid, "stat").rpartition(b")")[2].split()


def living_fields(pid: int) -> list[bytes]:
    """As `stat_fields`; of a thread that lives on if the main one has ended. Empty if none does.

    START_TICKS are those of the process.
    """
    return _living(pid)[1]


def living_thread(pid: int) -> int:
    """The number whose folder in /proc shows memory and files of a process.

    That is `pid`, or that of a thread: when the main thread has ended before others, /proc/PID is
    that of a zombie, without memory and files.
    """
    return _living(pid)[0]


def _living(pid: int) -> tuple[int, list[bytes]]:
    fields = stat_fields(pid)
    if not fields or fields[STATE] not in _ENDED:
        return pid, fields
    for tid in threads(pid) if int(fields[THREADS]) > 1 else ():
        living = stat_fields(tid)
        if living and living[STATE] not in _ENDED:
            return tid, [*living[:START_TICKS], fields[START_TICKS], *living[START_TICKS + 1 :]]
    return pid, []


def state(pid: int) -> str:
    """State as in ps(1): `R`, `S`, `T`, `Z` ...; empty if there is no such process.

    0.27 of psutil's time; so are all that read `stat_fields`.
    """
    fields = living_fields(pid) or stat_fields(pid)
    return fields[STATE].decode() if fields else ""


def is_alive(pid: int) -> bool:
    """Whether the process exists and is not a zombie."""
    return bool(living_fields(pid))


def is_suspended(pid: int) -> bool:
    """Whether the process was stopped by SIGSTOP, SIGTSTP or a debugger."""
    return state(pid).encode() in SUSPENDED


def describe_state(pid: int) -> str:
    """`state D (uninterruptible sleep), in nfs_wait`; the place only where it can be read."""
    letter = state(pid)
    if not letter:
        return "it has just exited"
    place = read(living_thread(pid), "wchan").decode("ascii", "replace").strip("\0\n 0")
    where = f", in {place}" if place else ""
    return f"state {letter} ({_STATES.get(letter, 'see man 5 proc')}){where}{_owner(pid)}"


def _owner(pid: int) -> str:
    """The owner, if our signals have no effect because it is another user (sudo)."""
    try:
        owner = os.stat(f"{ROOT}/{pid}").st_uid
    except OSError:
        return ""
    return "" if os.geteuid() in (0, owner) else f", belongs to user {owner}, who may end it"


def start_ticks(pid: int) -> int | None:
    """Start in clock ticks since boot; None if there is no such process, or a zombie."""
    fields = living_fields(pid)
    return int(fields[START_TICKS]) if fields else None


def threads(pid: int) -> list[int]:
    """Its threads, the main one included; empty if there is no such process."""
    try:
        return [int(name) for name in os.listdir(f"{ROOT}/{pid}/task")]
    except OSError:
        return []


def descriptors(pid: int) -> Iterator[tuple[int, str]]:
    """Number and target of each open file, such as `socket:[7]`; none of other users' processes.

    psutil leaves out sockets and removed files.
    """
    folder = f"{ROOT}/{living_thread(pid)}/fd"
    try:
        names = os.listdir(folder)
    except OSError:
        return
    for name in names:
        try:
            yield int(name), os.readlink(f"{folder}/{name}")
        except OSError:
            continue  # closed meanwhile; the others are still open


def children(pid: int) -> list[int]:
    """Pids of its children, zombies included; one that was born just now may be missing.

    0.01 of psutil's time, which reads all processes of the machine.
    """
    tasks = threads(pid)
    if tasks and not os.path.exists(f"{ROOT}/{pid}/task/{pid}/children"):
        # The kernel was built without it.
        return [
            child for child in pids() if stat_fields(child)[PARENT : PARENT + 1] == [b"%d" % pid]
        ]
    return [int(child) for each in tasks for child in read(pid, f"task/{each}/children").split()]


def family(roots: Iterable[int]) -> dict[int, int]:
    """Pid -> start in clock ticks of these processes and all their descendants, without zombies.

    0.24 of psutil's time.
    """
    found: dict[int, int] = {}
    waiting = list(roots)
    while waiting:
        pid = waiting.pop()
        started = start_ticks(pid)
        if started is not None and pid not in found:
            found[pid] = started
            waiting += children(pid)
    return found


def status_field(pid: int | str, name: str) -> str:
    """Value of a line of /proc/PID/status, such as `NSpid` or `CapEff`; empty if there is none."""
    wanted = f"{name}:".encode()
    for line in read(pid, "status").splitlines():
        if line.startswith(wanted):
            return line[len(wanted) :].decode().strip()
    return ""


def is_traced(pid: int) -> bool:
    """Whether a debugger is attached to it."""
    return status_field(living_thread(pid), "TracerPid") not in ("", "0")


def command_line(pid: int) -> list[str]:
    """Arguments of the process, its program first; empty for zombies and kernel threads.

    0.24 of psutil's time.
    """
    text = read_memory(pid, "cmdline").removesuffix(b"\0")
    return [os.fsdecode(word) for word in text.split(b"\0")] if text else []


def command_name(pid: int) -> str:
    """Name of the program, at most 15 bytes of it; empty if there is no such process."""
    return os.fsdecode(read(pid, "comm").removesuffix(b"\n"))


def environment(pid: int) -> list[bytes]:
    """Entries NAME=VALUE that the process was started with; 0.17 of psutil's time."""
    return read_memory(pid, "environ").split(b"\0")


def was_in_exec(pid: int) -> bool:
    """Whether `environment` was empty because exec had removed the old one and not yet set the new.

    That takes a tenth of a millisecond, or much longer on a busy machine; posix_spawn and vfork
    return in the middle of it. False for kernel threads, exiting processes, those without
    variables, and those that we may not read.
    """
    try:
        os.close(os.open(f"{ROOT}/{pid}/environ", os.O_RDONLY | os.O_CLOEXEC))
    except OSError:
        return False
    fields = stat_fields(pid)
    if not fields or fields[STATE] in _ENDED:
        return False
    if int(fields[FLAGS]) & (_EXITING | _KERNEL_THREAD):
        return False
    # exec sets the start of the code last. It may be complete by now.
    return fields[START_CODE] == b"0" or environment(pid) != [b""]


def details(pid: int, *names: str) -> dict[str, Any]:
    """Attributes of a process, by their names in psutil; None for those that may not be read.

    Empty if there is no such process, or a zombie. Not for the process of a run: see above.
    """
    import psutil

    try:
        found = psutil.Process(living_thread(pid)).as_dict([*names, "status"])
    except psutil.NoSuchProcess:
        return {}
    return {} if found["status"] in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD) else found


def pid_namespace(pid: int) -> str | None:
    """Identity of the pid namespace; None if it cannot be read."""
    try:
        return os.readlink(f"{ROOT}/{pid}/ns/pid")
    except OSError:
        return None


def udp_sockets() -> Iterator[tuple[int, str]]:
    """Local port and inode of every UDP socket, most of them twice; 0.02 of psutil's time.

    The kernel writes the table in pieces, and may skip a line if sockets are closed between two
    of them; a second reading finds it.
    """
    for table in 2 * ("udp", "udp6"):
        for line in read("net", table).splitlines()[1:]:
            fields = line.split()
            yield int(fields[1].rpartition(b":")[2], 16), fields[9].decode()
