"""What hosts and robots have in common: sshd, and what can happen to them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

import psutil

from tests.support.children import children
from tests.support.hosts.computer import Computer
from tests.support.repository import REPOSITORY


class Remote(Computer):
    """A computer to which the operator has a key."""

    kinds = (*Computer.kinds, "-p")
    user = "root"  # who logs in, if the test does not say
    public_key = ""  # of its sshd
    _relay: subprocess.Popen[str] | None = None

    def kill_sshd_sessions(self) -> None:
        """Kill the processes of sshd that serve a session, but not the one that listens.

        What runs in the sessions goes on, without a terminal or stdin.
        """
        listeners = children(self.pid)
        kill(pid for pid in self.sshd_pids() if pid not in listeners)

    def sshd_pids(self) -> list[int]:
        pids = {process.pid for process in self.processes()}
        named = [one.info for one in psutil.process_iter(["name", "pid"])]
        return [one["pid"] for one in named if one["name"] == "sshd" and one["pid"] in pids]

    def full_disk(self, path: Path | str) -> None:
        """Mount a file system without free space on the folder."""
        self.run(["mkdir", "-p", path])
        self.run(["mount", "-t", "tmpfs", "-o", "size=64k,mode=1777", "tmpfs", path])
        self.run(["dd", "if=/dev/zero", f"of={path}/filling", "bs=4k"], check=False)

    def free_disk(self, path: Path | str) -> None:
        """Undo `full_disk`."""
        self.run(["umount", "--lazy", path])

    def slow_link(
        self, *, delay_s: float = 0.0, loss: float = 0.0, bytes_per_s: float = float("inf")
    ) -> None:
        """Delay each packet in both directions, and lose a share of them (0.05: 5 %)."""
        self.normal_link()
        ends = self.port.split()
        words = (*ends, delay_s, loss, bytes_per_s)
        self._relay = subprocess.Popen(
            [*self.port.enter, sys.executable, "-m", "tests.support.hosts.relay", *map(str, words)],
            cwd=REPOSITORY,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert self._relay.stdout is not None
        assert self._relay.stdout.readline() == "ready\n"

    def normal_link(self) -> None:
        """Undo `slow_link`."""
        if self._relay is None:
            return
        self._relay.kill()
        self._relay.communicate()
        self._relay = None
        self.port.join()


def kill(pids: Iterable[int]) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
