"""Files of Fast DDS in a temporary folder, with real locks."""

from __future__ import annotations

import contextlib
import fcntl
import os
from pathlib import Path
from unittest import mock

from launcher.posix import proc
from launcher.run.monitor.shared_memory import SETTLING_S, free, stale

SEGMENT = "fastrtps_0123456789abcdef"
OTHER = "fastrtps_fedcba9876543210"
PORT = "fastrtps_port7411"
OWNER = 4242
MUTEX = f"sem.{PORT}_mutex"
UNLOCKED, LOCKED = b"\1" + bytes(31), bytes(32)  # contents of a semaphore


class Shelf:
    """A /dev/shm and a /proc of the test's own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.proc = folder / "shm", folder / "proc"
        self.folder.mkdir()
        self.proc.mkdir()
        self._locks = contextlib.ExitStack()
        self._locks.enter_context(mock.patch.object(proc, "ROOT", str(self.proc)))
        self._files = contextlib.ExitStack()
        self._lines = ""

    def put(self, *names: str) -> None:
        for name in names:
            content = UNLOCKED if name.startswith("sem.") else b"x" * 5000
            (self.folder / name).write_bytes(b"" if name.endswith("l") else content)

    def lock(self, name: str, mode: int = fcntl.LOCK_EX, *, pid: int | None = OWNER) -> None:
        """Lock a file; /proc/locks says that `pid` did, or nothing at all."""
        file = self._files.enter_context((self.folder / name).open("rb"))
        fcntl.flock(file, mode)
        if pid is not None:
            at = os.fstat(file.fileno())
            device = f"{os.major(at.st_dev):02x}:{os.minor(at.st_dev):02x}"
            self._lines += f"1: FLOCK  ADVISORY  WRITE {pid} {device}:{at.st_ino} 0 EOF\n"
            (self.proc / "locks").write_text(self._lines)

    def maps(self, *names: str, pid: int = OWNER, run_id: str = "") -> None:
        """What `pid` has mapped, and which run it belongs to."""
        (self.proc / str(pid)).mkdir(exist_ok=True)
        lines = [f"7f00-7f01 rw-s 0 00:1b 1   {self.folder / name}\n" for name in names]
        (self.proc / str(pid) / "maps").write_text("".join(lines))
        (self.proc / str(pid) / "environ").write_text(f"A=1\0LAUNCHER_RUN_ID={run_id}\0")

    def stale(self, age_s: float = 2 * SETTLING_S) -> list[str]:
        """Names of what is stale when the newest file is that old."""
        now_s = max(path.lstat().st_ctime for path in self.folder.iterdir()) + age_s
        return [s.name for s in stale(folder=self.folder, now_s=now_s)]

    def free(self, *names: str) -> int:
        return free(names, folder=self.folder)

    @property
    def left(self) -> set[str]:
        return set(os.listdir(self.folder))

    def release(self) -> None:
        """All locks."""
        self._files.close()
        self._lines = ""
        (self.proc / "locks").write_text("")

    def close(self) -> None:
        self._files.close()
        self._locks.close()
