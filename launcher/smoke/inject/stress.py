"""Takes time, CPU, memory or disk for as long as its standard input is open, at most `for_s`.

One JSON object on standard input says what; on standard output it answers `{"begins": true}` when
that can be seen, unless it is in force at once, `{"ready": true}` when it is in force, or
`{"error": TEXT}`. At its end everything is as before, and if it is killed, the kernel gives memory
and disk back, its children end by themselves, and the launcher continues a process that is
suspended.
"""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import select
import signal
import sys
import tempfile
import time
from typing import Any

from launcher.base import strict_json
from launcher.smoke.inject.processors import excess

SPARE_S = 0.5  # the launcher ends it; beyond that it ends itself
# A process runs for so long at a time: long enough that switching costs little, and short enough
# that a process at 10 Hz is late and not still.
PERIOD_S = 0.02
SHORTEST_RUN_S = 0.001
CHUNK_BYTES = 4 << 20
STEP_BYTES = 256 << 20  # of disk, between two looks at the input
BLOCK_BYTES = 4096
REFILL_S = 0.2
SPINS = 20_000  # of a burner, between two looks whether its parent is there: a millisecond
SPARE_PART = 20  # of all memory, which stays free: a twentieth
_IN_MEMORY = ("tmpfs", "ramfs")


class StressRefusedError(Exception):
    """What is requested cannot be done, or would harm the machine."""


class StressInput:
    """The end of the input, or of the time, ends everything."""

    def __init__(self, for_s: float) -> None:
        self._end_s = time.monotonic() + for_s + SPARE_S

    def is_over(self, wait_s: float = 0.0, *more: int) -> bool:
        """Whether it is over within this time; also if one of these descriptors is readable."""
        left_s = self._end_s - time.monotonic()
        readable = select.select([0, *more], [], [], max(0.0, min(wait_s, left_s)))[0]
        return bool(readable) or left_s <= 0.0


def slow(request: dict[str, Any], over: StressInput) -> None:
    """Let a process group run for one part of `factor` of the time.

    How long it is suspended follows from how long it really ran, so that a late wake-up does not
    change its part.
    """
    group, factor = request["pid"], request["factor"]
    run_s = max(SHORTEST_RUN_S, PERIOD_S / factor)
    leader = os.pidfd_open(group)
    ready()
    try:
        while not over.is_over(run_s * (factor - 1.0), leader):
            begun_s = time.monotonic()  # before: what continues may get our processor
            os.killpg(group, signal.SIGCONT)
            if over.is_over(max(SHORTEST_RUN_S, PERIOD_S / factor), leader):
                break
            os.killpg(group, signal.SIGSTOP)
            run_s = time.monotonic() - begun_s
    except ProcessLookupError:
        return
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGCONT)


def cpu(request: dict[str, Any], over: StressInput) -> None:
    """Keep `cores` processors busy, where the process may run, and with its priority.

    StressRefusedError if these are too many for where it may run.
    """
    pid = request["pid"]
    if pid is not None:
        with contextlib.suppress(OSError):
            os.sched_setaffinity(0, os.sched_getaffinity(pid))
            os.setpriority(os.PRIO_PROCESS, 0, os.getpriority(os.PRIO_PROCESS, pid))
    available = len(os.sched_getaffinity(0))
    cores = request.get("cores") or available
    if problem := excess(cores, available):
        raise StressRefusedError(f"cpu: {problem}")
    begins()
    burners: list[int] = []
    # Until all are there they wait for the end of this pipe: those that burn already would leave
    # less and less time to make the others.
    waiting, begin = os.pipe()
    try:
        while len(burners) < cores and not over.is_over():
            burners.append(_burner(waiting, begin))
        if len(burners) == cores:
            ready()
            os.close(begin)
            while not over.is_over(1.0):
                pass
    finally:
        for burner in burners:
            os.kill(burner, signal.SIGKILL)
        for burner in burners:
            os.waitpid(burner, 0)


def _burner(waiting: int, begin: int) -> int:
    """The id of a process that burns from the end of the pipe on, and ends with this one."""
    parent, burner = os.getpid(), os.fork()
    if burner:
        return burner
    try:
        os.close(begin)
        os.read(waiting, 1)
        while os.getppid() == parent:
            for _ in range(SPINS):
                pass
    finally:
        os._exit(0)


def memory(request: dict[str, Any], over: StressInput) -> None:
    """Use `size` bytes of memory; StressRefusedError if the machine does not have them."""
    size = request["size"]
    refuse_memory(size, "memory")
    adjust = "/proc/self/oom_score_adj"  # if it gets scarce, this is killed before others
    with contextlib.suppress(OSError), open(adjust, "w", encoding="ascii") as file:
        file.write("1000")
    try:
        used = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    except (OSError, ValueError, OverflowError) as error:
        raise StressRefusedError(f"cannot get {megabytes(size)}: {error}") from None
    begins()
    content = b"\x01" * CHUNK_BYTES
    for begin in range(0, size, CHUNK_BYTES):
        used[begin : begin + CHUNK_BYTES] = content[: size - begin]
        if over.is_over():
            return
    ready()
    while not over.is_over(1.0):
        pass


def refuse_memory(size: int, what: str) -> None:
    """StressRefusedError if so much is not available: the kernel would kill something."""
    facts = {}
    with open("/proc/meminfo", encoding="ascii") as file:
        for line in file:
            name, value = line.split()[:2]
            facts[name.rstrip(":")] = int(value) * 1024
    available = min(facts["MemAvailable"], *_left_in_groups())
    spare = facts["MemTotal"] // SPARE_PART
    if size > available - spare:
        raise StressRefusedError(
            f"{what}: {megabytes(size)} would make the kernel kill processes: "
            f"{megabytes(available)} are available, of which {megabytes(spare)} stay free"
        )


def _left_in_groups() -> list[int]:
    """What the control groups around this process may still use."""
    with open("/proc/self/cgroup", encoding="utf-8") as file:
        lines = [line.rstrip("\n").split(":", 2) for line in file]
    left = [sys.maxsize]
    for number, names, path in lines:
        root, limit, usage = "/sys/fs/cgroup", "memory.max", "memory.current"
        if number != "0":
            root, limit, usage = f"{root}/memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        if number != "0" and "memory" not in names.split(","):
            continue
        while path:
            with contextlib.suppress(OSError, ValueError):  # "max", or not mounted here
                most = _number_in(f"{root}{path}/{limit}")
                left.append(most - _number_in(f"{root}{path}/{usage}"))
            path = path.rpartition("/")[0]
    return left


def _number_in(path: str) -> int:
    with open(path, encoding="ascii") as file:
        return int(file.read())


def disk(request: dict[str, Any], over: StressInput) -> None:
    """Fill the file system of `folder` up to `leave` bytes, with a file that has no name."""
    folder, leave = request["folder"], request.get("leave", 0)
    descriptor = _nameless_file(folder)
    if _file_system(os.fstat(descriptor).st_dev) in _IN_MEMORY:
        refuse_memory(max(0, _free(descriptor) - leave), f"{folder} is in memory")
    size = 0
    begins()
    while not over.is_over():
        size = _grow(descriptor, size, leave, over)
        ready()
        over.is_over(REFILL_S)


def _nameless_file(folder: str) -> int:
    try:
        return os.open(folder, os.O_TMPFILE | os.O_WRONLY, 0o600)
    except OSError as error:
        if error.errno not in (errno.EOPNOTSUPP, errno.EISDIR):
            raise StressRefusedError(f"cannot write in {folder}: {error.strerror}") from None
    descriptor, path = tempfile.mkstemp(dir=folder)
    os.unlink(path)
    return descriptor


def _grow(descriptor: int, size: int, leave: int, over: StressInput) -> int:
    """Let the file take what is free; its new size. The C library writes where it must."""
    step = STEP_BYTES
    while step >= BLOCK_BYTES and not over.is_over():
        step = min(step, (_free(descriptor) - leave) // BLOCK_BYTES * BLOCK_BYTES)
        if step <= 0:
            break
        try:
            os.posix_fallocate(descriptor, size, step)
        except OSError as error:
            if error.errno == errno.EFBIG:
                raise StressRefusedError(
                    f"a file may not be larger than {megabytes(size)}"
                ) from None
            step //= 2
        else:
            size += step
    return size


def _free(descriptor: int) -> int:
    """Bytes that this user may still use."""
    facts = os.fstatvfs(descriptor)
    return facts.f_frsize * (facts.f_bavail if os.geteuid() else facts.f_bfree)


def _file_system(device: int) -> str:
    """`ext4`; empty if it is not known."""
    wanted = f"{os.major(device)}:{os.minor(device)}"
    with open("/proc/self/mountinfo", encoding="utf-8", errors="replace") as file:
        for line in file:
            if line.split()[2] == wanted:
                return line.partition(" - ")[2].split()[0]
    return ""


def megabytes(size: int) -> str:
    """`200 MB`, of which 1 MB are 1024 kB, as in the words of an injection."""
    return f"{size / 1024**2:.0f} MB"


_is_ready = False


def begins() -> None:
    """Say that it can be seen from now on, although it is not yet in force."""
    _say({"begins": True})


def ready() -> None:
    """Say, once, that it is in force."""
    global _is_ready
    if not _is_ready:
        _is_ready = True
        _say({"ready": True})


def _say(answer: dict[str, Any]) -> None:
    with contextlib.suppress(OSError):
        os.write(1, strict_json.packed(answer).encode() + b"\n")


WORKS = {"slow": slow, "cpu": cpu, "memory": memory, "disk": disk}


def main() -> None:
    line = b""
    while not line.endswith(b"\n"):  # not buffered: `select` sees what follows
        if not (more := os.read(0, 1)):
            return
        line += more
    request = strict_json.unpacked(line)
    try:
        WORKS[request["kind"]](request, StressInput(request["for_s"]))
    except (StressRefusedError, OSError) as error:
        _say({"error": str(error)})


if __name__ == "__main__":
    main()
