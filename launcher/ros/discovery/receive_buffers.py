"""Gives the socket on which a new participant is answered room for the answers of many.

Fast DDS leaves it at the kernel's default, 208 KiB. Each participant that runs already sends a new
one about 35 datagrams at once, so those of a dozen fill it while the new one waits for a processor.
What is lost then is repeated with the next heartbeat of the other one, a second later.

The buffer is set from outside, so that nothing of it is in the environment of a node: a copy of its
descriptor (pidfd_getfd(2)) is a socket as any other. Who may not debug the node gets none.
"""

from __future__ import annotations

import contextlib
import os
import socket

from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Container

SIZE_BYTES = 4 << 20  # a hundred participants; it is taken as it is filled
_PIDFD_GETFD = 438  # of Linux, on every architecture


def enlarge(pid: int, inodes: Container[str]) -> set[str]:
    """Enlarge the receive buffers of the sockets of a process that have one of these inodes.

    The inodes of such sockets. They get as much as the kernel allows (net.core.rmem_max).
    """
    found = set()
    for fd, target in proc.descriptors(pid):
        if target.startswith("socket:[") and (inode := target[8:-1]) in inodes:
            found.add(inode)
            with contextlib.suppress(OSError, ValueError), _copy(pid, fd) as one:
                size = min(SIZE_BYTES, int(proc.read("sys", "net/core/rmem_max")))
                # The kernel doubles what it is given.
                if one.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) < 2 * size:
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
    return found


def _copy(pid: int, fd: int) -> socket.socket:
    """The socket of another process; OSError."""
    import _ctypes  # ctypes itself takes 5 ms to import

    syscall = _ctypes.dlsym(_ctypes.dlopen(None, 0), "syscall")  # type: ignore[arg-type]
    pidfd = os.pidfd_open(pid)
    try:
        copy: int = _ctypes.call_cdeclfunction(syscall, (_PIDFD_GETFD, pidfd, fd, 0))
    finally:
        os.close(pidfd)
    if copy < 0:
        raise PermissionError
    return socket.socket(fileno=copy)
