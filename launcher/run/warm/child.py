"""Makes of a forked process what an executed one would be, up to the first line of its program."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import importlib
import io
import os
import resource
import struct
import sys

from launcher.posix import limits_exec, proc
from launcher.run.warm.stack_answer import offer
from launcher.run.warm.warm_program import Program

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any


_FAILED = 127
_RLIMITS = 16  # of Linux


def become(
    content: Mapping[str, Any],
    fds: Sequence[int],
    added: Mapping[str, str],
    restore_threads: Callable[[], None],
) -> Callable[[], object]:
    """Wait for the launcher's word, then become the process that it has described.

    `fds` are standard input, output and error, and `status`. What is left to do is to call the
    result. Does not return if the launcher has gone, or if something was refused.
    """
    *streams, status = fds
    if not os.read(status, 1):
        os._exit(0)
    setting = ""
    try:
        for number, fd in enumerate(streams):
            os.dup2(fd, number)
        for fd in {*streams} - {0, 1, 2}:
            os.close(fd)
        _inherit(os.getppid())
        os.chdir(content["cwd"])
        for setting in content["limits"]:
            limits_exec.apply(setting)
        setting = ""
        _set_environment({**added, **content["environment"]})
        set_title(content["title"], content["environment"])
        set_name(os.path.basename(content["executed"]))
        _open_streams()
        _renew()
        program = Program(content)
        restore_threads()
        if content["answers_stacks"]:
            offer()
    except OSError as error:
        _refuse(status, error.errno or errno.EIO, setting)
    except ValueError:  # what `resource` makes of EPERM and EINVAL
        _refuse(status, errno.EPERM, setting)
    os.close(status)
    return program.run


def _refuse(status: int, number: int, setting: str) -> None:
    os.write(status, f"{number} {setting}".encode())
    os._exit(_FAILED)


def _inherit(launcher: int) -> None:
    """Take over what a child has from its parent, which may have changed since we were started."""
    # Of open files it has as many as the launcher at first, which may have raised its own limit.
    for which in {*range(_RLIMITS)} - {resource.RLIMIT_NOFILE}:
        with contextlib.suppress(OSError, ValueError):  # we cannot raise our own
            limit = resource.prlimit(launcher, which)
            if limit != resource.getrlimit(which):
                resource.setrlimit(which, limit)
    with contextlib.suppress(OSError):
        nice = os.getpriority(os.PRIO_PROCESS, launcher)
        if nice != os.getpriority(os.PRIO_PROCESS, 0):
            os.setpriority(os.PRIO_PROCESS, 0, nice)
    with contextlib.suppress(OSError):
        cpus = os.sched_getaffinity(launcher)
        if cpus != os.sched_getaffinity(0):
            os.sched_setaffinity(0, cpus)
    umask = proc.status_field(launcher, "Umask")
    if umask:
        os.umask(int(umask, 8))


def _set_environment(environment: Mapping[str, str]) -> None:
    """Also for libraries in C, which read it by getenv."""
    for name in os.environ.keys() - environment.keys():
        del os.environ[name]
    for name, value in environment.items():
        if os.environ.get(name) != value:
            os.environ[name] = value


def _open_streams() -> None:
    """Standard streams as the interpreter makes them, for the descriptors that there are now."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        stream = _stream(number, name, getattr(sys, f"__{name}__"))
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def _stream(number: int, name: str, before: Any) -> io.TextIOWrapper:
    """As `create_stdio` of CPython's pylifecycle.c; encoding and errors are those of `before`."""
    writes = number > 0
    is_unbuffered: bool = before.write_through
    buffering = 0 if is_unbuffered and writes else -1
    buffered: Any = open(number, "wb" if writes else "rb", buffering, closefd=False)  # noqa: SIM115
    raw = getattr(buffered, "raw", buffered)
    raw.name = f"<{name}>"
    text = io.TextIOWrapper(
        buffered,
        encoding=before.encoding,
        errors=before.errors,
        newline="\n",
        line_buffering=not is_unbuffered and (raw.isatty() or number == 2),
        write_through=is_unbuffered,
    )
    text.mode = "w" if writes else "r"  # type: ignore[misc]
    return text


def _renew() -> None:
    """Forget what would be the same in several processes, or is older than they are.

    `random` and `uuid` need nothing: they notice a fork.
    """
    importlib.invalidate_caches()
    loaded = sys.modules
    if "linecache" in loaded:
        loaded["linecache"].clearcache()
    if "threading" in loaded:
        loaded["threading"].main_thread()._set_native_id()
    if "numpy.random" in loaded:
        loaded["numpy.random"].seed()
    if "multiprocessing.process" in loaded:
        process = loaded["multiprocessing.process"]
        key = process.AuthenticationString(os.urandom(32))
        process.current_process()._config["authkey"] = key
    if "logging" in loaded:
        _restart_log_clock(loaded["logging"])


def _restart_log_clock(logging: Any) -> None:
    """The zero of `relativeCreated`; its unit differs between versions of Python."""
    import time

    is_in_ns = isinstance(logging._startTime, int)
    logging._startTime = time.time_ns() if is_in_ns else time.time()


# ---- name and command line

_PR_SET_MM, _PR_SET_MM_MAP = 35, 14
_NAME_BYTES = 15
# Fields of /proc/self/stat behind the state (proc(5)): number - 3.
_START_CODE, _END_CODE, _START_STACK = 23, 24, 25
_START_DATA, _END_DATA, _START_BRK, _ARG_START, _ARG_END, _ENV_START, _ENV_END = range(42, 49)


def set_name(name: str) -> None:
    """As `ps -o comm` and `pgrep` show it."""
    with open("/proc/self/comm", "wb") as file:
        file.write(os.fsencode(name)[:_NAME_BYTES])


def set_title(words: Sequence[str], environment: Mapping[str, str]) -> None:
    """The command line and environment in /proc.

    The kernel reads them from the memory of the process. PR_SET_MM_MAP says where they are: without
    privileges, but only in a kernel with CONFIG_CHECKPOINT_RESTORE, as distributions have it.
    Elsewhere the command line is written over the old one, cut off where that ends, and
    /proc/PID/environ stays as it was.
    """
    line = b"".join(os.fsencode(word) + b"\0" for word in words)
    variables = b"".join(os.fsencode(f"{k}={v}") + b"\0" for k, v in environment.items())
    fields = [*map(_number, proc.stat_fields(os.getpid()))]
    if not _map(fields, line, variables):
        _overwrite(fields[_ARG_START], fields[_ARG_END], line)


def _number(field: bytes) -> int:
    return int(field) if field.lstrip(b"-").isdigit() else 0


def _map(fields: Sequence[int], line: bytes, variables: bytes) -> bool:
    libc = ctypes.CDLL(None)
    libc.malloc.restype = ctypes.c_void_p
    libc.malloc.argtypes = [ctypes.c_size_t]
    begin = libc.malloc(len(line) + len(variables) + 1)  # for as long as the process lives
    if not begin:
        return False
    ctypes.memmove(begin, line + variables, len(line) + len(variables))
    middle, end = begin + len(line), begin + len(line) + len(variables)
    libc.sbrk.restype = ctypes.c_void_p
    libc.sbrk.argtypes = [ctypes.c_ssize_t]
    # struct prctl_mm_map of linux/prctl.h; no new auxiliary vector, no other executable.
    described = struct.pack(
        "11QQIi",
        *(fields[place] for place in (_START_CODE, _END_CODE, _START_DATA, _END_DATA, _START_BRK)),
        libc.sbrk(0),
        *(fields[_START_STACK], begin, middle, middle, end),
        *(0, 0, -1),
    )
    buffer = ctypes.create_string_buffer(described, len(described))
    libc.prctl.argtypes = [ctypes.c_int, *[ctypes.c_ulong] * 4]
    size, place = len(described), ctypes.addressof(buffer)
    return not libc.prctl(_PR_SET_MM, _PR_SET_MM_MAP, place, size, 0)


def _overwrite(begin: int, end: int, line: bytes) -> None:
    room = end - begin
    if room > 1:
        ctypes.memmove(begin, line[: room - 1].ljust(room, b"\0"), room)
