"""The namespaces of a run of the fault matrix, and the processes in them."""

from __future__ import annotations

import ctypes
import fcntl
import os
import socket
import struct
from pathlib import Path

import psutil


def command_line(pid: int) -> list[str]:
    """Its words; none if it is gone."""
    try:
        return psutil.Process(pid).cmdline()
    except psutil.Error:
        return []


def description(pid: int) -> str:
    """The end of its command line, or its pid."""
    return " ".join(command_line(pid))[-200:] or f"pid {pid}"


def is_alive(pid: int) -> bool:
    """Whether a thread of it lives; psutil takes one for a zombie whose main thread has ended."""
    try:
        tasks = os.listdir(f"/proc/{pid}/task")
        return any(_state(f"/proc/{pid}/task/{task}/stat") not in ("Z", "X", "") for task in tasks)
    except OSError:
        return False


def _state(path: str) -> str:
    try:
        return Path(path).read_text().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def isolate() -> None:
    """An empty /dev/shm, and a network with nothing but the loopback."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mount(b"tmpfs", b"/dev/shm", b"tmpfs", 0, b"mode=1777"):
        raise OSError(ctypes.get_errno(), "mount")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        is_up = struct.pack("16sh14x", b"lo", 1)  # IFF_UP
        fcntl.ioctl(any_socket, 0x8914, is_up)  # SIOCSIFFLAGS
