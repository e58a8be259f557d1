"""Who listens in a network namespace."""

from __future__ import annotations

from launcher.posix import proc

SSH_PORT = 22
_LISTEN = "0A"  # state of a socket in /proc/net/tcp


def has_sshd(pid: int) -> bool:
    """Whether somebody listens on ssh's port in the network namespace of the process."""
    return SSH_PORT in _listening(pid)


def _listening(pid: int) -> set[int]:
    tables = (proc.read(pid, f"net/{name}").decode().splitlines()[1:] for name in ("tcp", "tcp6"))
    rows = [line.split() for table in tables for line in table]
    return {int(row[1].rpartition(":")[2], 16) for row in rows if row[3] == _LISTEN}
