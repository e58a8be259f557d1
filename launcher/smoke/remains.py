"""Remains: what a run leaves behind: processes, and names in /dev/shm."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import time
from collections.abc import Callable
from pathlib import Path

from launcher.engine.cleanup.run_id import run_id_of

SHARED_MEMORY = Path("/dev/shm")
PROC = Path("/proc")
SETTLE_S = 3.0  # the launcher's watchdog may still be at work
LOOK_S = 0.05
_MAPPED = re.compile(rb" /dev/shm/([^\n(]+)")
_PORT = re.compile(r"port(\d+)")
_FIRST_PORT, _PORTS_PER_DOMAIN = 7400, 250


def processes_of(launcher_pid: int, *, proc: Path = PROC) -> dict[int, str]:
    """Pid -> command of everything that carries a run id of this launcher, but the launcher."""
    found: dict[int, str] = {}
    for name in filter(str.isdigit, os.listdir(proc)):
        run_id = run_id_of(int(name))
        if run_id is not None and run_id.partition("-")[0] == str(launcher_pid):
            found[int(name)] = _command(int(name), proc)
    found.pop(launcher_pid, None)
    return found


def _command(pid: int, proc: Path) -> str:
    try:
        words = (proc / str(pid) / "cmdline").read_bytes().split(b"\0")
    except OSError:
        return "?"
    return " ".join(os.fsdecode(word) for word in words if word) or "?"


def end_processes(
    launcher_pid: int, *, clock: Callable[[], float] = time.monotonic
) -> tuple[str, ...]:
    """What is left after a moment, as `command [pid]`; it is killed."""
    deadline_s = clock() + SETTLE_S
    while (left := processes_of(launcher_pid)) and clock() < deadline_s:
        time.sleep(LOOK_S)
    for pid in left:
        _kill(pid, launcher_pid)
    return tuple(f"{command} [{pid}]" for pid, command in left.items())


def _kill(pid: int, launcher_pid: int) -> None:
    """Only if it still is one of the run: its number may belong to somebody else by now."""
    try:
        pidfd = os.pidfd_open(pid)
    except OSError:
        return
    try:
        run_id = run_id_of(pid)
        if run_id is not None and run_id.partition("-")[0] == str(launcher_pid):
            signal.pidfd_send_signal(pidfd, signal.SIGKILL)
    except ProcessLookupError:
        pass  # it has gone
    finally:
        os.close(pidfd)


class SharedMemory:
    """Notes what the processes of a run have in /dev/shm while they live."""

    def __init__(self, domain_id: int, *, folder: Path = SHARED_MEMORY, proc: Path = PROC) -> None:
        first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain_id
        self._ports = range(first, first + _PORTS_PER_DOMAIN)
        self._folder = folder
        self._proc = proc
        self._names: set[str] = set()
        # What is there already is not ours, even if our processes use it.
        self._before = frozenset(path.name for path in folder.iterdir()) if folder.exists() else ()

    def note(self, launcher_pid: int) -> None:
        """Look now; a few milliseconds."""
        for pid in processes_of(launcher_pid, proc=self._proc):
            self._names |= set(filter(self._is_private, self._mapped(pid)))

    def free_ports(self) -> None:
        """Remove the ports of our domain that nobody uses, when everything in it has ended.

        Whoever sends to a node that has just gone makes its port anew, the probe as well, and the
        launcher leaves a port alone as long as anybody on the machine might use it. Here it is
        known that the domain was ours alone.
        """
        ours = {path.name for path in self._folder.glob("*fast*_port*")}
        for name in filter(self._is_private, ours - self._in_use(ours)):
            with contextlib.suppress(OSError):
                (self._folder / name).unlink()

    def left(self) -> tuple[str, ...]:
        """Those names that are still there although no process has them mapped.

        Ports are no fault of the run, see `free_ports`.
        """
        names = {name for name in self._names if not _PORT.search(name)}
        there = {name for name in names if (self._folder / name).exists()}
        return tuple(sorted(there - self._in_use(there)))

    def _in_use(self, names: set[str]) -> set[str]:
        """Those of the names that a process has mapped."""
        if not names:
            return set()
        pids = filter(str.isdigit, os.listdir(self._proc))
        return names & {name for pid in pids for name in self._mapped(int(pid))}

    def _mapped(self, pid: int) -> set[str]:
        try:
            maps = (self._proc / str(pid) / "maps").read_bytes()
        except OSError:
            return set()
        return {os.fsdecode(name) for name in _MAPPED.findall(maps)}

    def _is_private(self, name: str) -> bool:
        """Ports of DDS outside of our domain are shared with all domains."""
        port = _PORT.search(name)
        return name not in self._before and (port is None or int(port[1]) in self._ports)
