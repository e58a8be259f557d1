"""What `ps` and /proc tell of a process: its command line, environment and name.

The kernel reads command line and environment from the memory of the process. `PR_SET_MM_MAP` says
where they are, which needs no privilege, but a kernel with checkpoints (CONFIG_CHECKPOINT_RESTORE,
as distributions have it). Without it the command line is written over the old one, cut off where
that ends, and /proc/PID/environ stays as it was.
"""

from __future__ import annotations

import ctypes
import os
import struct

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

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
    """The command line and environment in /proc."""
    line = b"".join(os.fsencode(word) + b"\0" for word in words)
    variables = b"".join(os.fsencode(f"{k}={v}") + b"\0" for k, v in environment.items())
    with open("/proc/self/stat", "rb") as file:
        fields = [*map(_number, file.read().rpartition(b")")[2].split())]
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
