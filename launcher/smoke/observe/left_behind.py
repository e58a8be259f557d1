"""What a run leaves behind: processes, and names in /dev/shm."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import time
from pathlib import Path

from launcher.posix import proc
from launcher.posix.cleanup.run_id import run_id_of
from launcher.posix.ports import multicast_port

SHARED_MEMORY = Path("/dev/shm")
SETTLE_S = 3.0  # the launcher's watchdog may still be at work
POLL_S = 0.05
_FOLDER = f"{SHARED_MEMORY}/"
_PORT = re.compile(r"port(\d+)")


def processes_of(launcher_pid: int) -> dict[int, str]:
    """Pid -> command of all processes of the run of this launcher, except the launcher."""
    pids = [pid for pid in proc.pids() if pid != launcher_pid and is_of_run(pid, launcher_pid)]
    return {pid: " ".join(filter(None, proc.command_line(pid))) or "?" for pid in pids}


def is_of_run(pid: int, launcher_pid: int) -> bool:
    """Whether a process carries the run id of this launcher."""
    run_id = run_id_of(pid)
    return run_id is not None and run_id.partition("-")[0] == str(launcher_pid)


def end_processes(launcher_pid: int) -> tuple[str, ...]:
    """Kill the processes that are left after a moment; `command [pid]` of each."""
    deadline_s = time.monotonic() + SETTLE_S
    while (left := processes_of(launcher_pid)) and time.monotonic() < deadline_s:
        time.sleep(POLL_S)
    for pid in left:
        _kill(pid, launcher_pid)
    return tuple(f"{command} [{pid}]" for pid, command in left.items())


def _kill(pid: int, launcher_pid: int) -> None:
    """Only if it is still one of the run: the pid may have been reused."""
    try:
        pidfd = os.pidfd_open(pid)
    except OSError:
        return
    try:
        if is_of_run(pid, launcher_pid):
            signal.pidfd_send_signal(pidfd, signal.SIGKILL)
    except ProcessLookupError:
        pass  # it has exited
    finally:
        os.close(pidfd)


class SharedMemory:
    """Notes which files in /dev/shm the processes of a run have mapped."""

    def __init__(self, domain_id: int) -> None:
        self._ports = range(multicast_port(domain_id), multicast_port(domain_id + 1))
        self._names: set[str] = set()
        # Existing files are not of this run, even if its processes use them.
        self._before = frozenset(path.name for path in SHARED_MEMORY.glob("*"))

    def note(self, launcher_pid: int) -> None:
        """Note the current files; takes a few milliseconds."""
        for pid in processes_of(launcher_pid):
            self._names |= set(filter(self._is_private, self._mapped(pid)))

    def free_ports(self) -> None:
        """Remove the unused port files of the leased domain, when all its processes have exited.

        Sending to a node that has just exited creates its port file again, and the launcher keeps
        ports that another process on the machine might use. The lease excludes that.
        """
        ours = {path.name for path in SHARED_MEMORY.glob("*fast*_port*")}
        for name in filter(self._is_private, ours - self._in_use(ours)):
            with contextlib.suppress(OSError):
                (SHARED_MEMORY / name).unlink()

    def left(self) -> tuple[str, ...]:
        """The noted files that still exist and that no process has mapped, except ports."""
        names = {name for name in self._names if not _PORT.search(name)}
        there = {name for name in names if (SHARED_MEMORY / name).exists()}
        return tuple(sorted(there - self._in_use(there)))

    def _in_use(self, names: set[str]) -> set[str]:
        """Those that a process has mapped."""
        if not names:
            return set()
        return names & {name for pid in proc.pids() for name in self._mapped(pid)}

    def _mapped(self, pid: int) -> set[str]:
        paths = proc.mapped(pid)
        return {path[len(_FOLDER) :] for path in paths if path.startswith(_FOLDER)}

    def _is_private(self, name: str) -> bool:
        """DDS ports outside of the leased domain are shared between domains."""
        port = _PORT.search(name)
        return name not in self._before and (port is None or int(port[1]) in self._ports)
