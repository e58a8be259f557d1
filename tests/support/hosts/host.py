"""A host without systemd: namespaces of its own, and sshd."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

from launcher import proc
from tests.support.hosts.boot import Boot
from tests.support.hosts.computer import Computer, python_path
from tests.support.hosts.keys import allow_login, make_key
from tests.support.hosts.network import Port
from tests.support.hosts.requirements import program
from tests.support.waiting import wait_until

SSH_PORT = 22
_LISTEN = "0A"  # state of a socket in /proc/net/tcp

_CONFIG = """\
Port {port}
HostKey {key}
PermitRootLogin prohibit-password
PasswordAuthentication no
KbdInteractiveAuthentication no
UsePAM no
UseDNS no
PrintMotd no
LogLevel VERBOSE
AcceptEnv LANG LC_*
Subsystem sftp internal-sftp
"""


class Host(Computer):
    """Root logs in by key; files are the machine's, but for home, /etc, /run, /tmp and /dev/shm."""

    kinds = (*Computer.kinds, "-p")

    def __init__(self, name: str, port: Port, folder: Path, public_key: str) -> None:
        super().__init__(name, port, folder)
        allow_login(self.home, public_key)
        self._boot: Boot | None = None
        self.public_key = ""
        self.new_host_key()
        self.power_on()

    @property
    def sshd_log(self) -> str:
        return (self.folder / "sshd.log").read_text(encoding="utf-8", errors="replace")

    def new_host_key(self) -> None:
        """Give sshd another key, as after a new installation; `public_key` is the new one."""
        self.public_key = make_key(self.folder / "host_key")
        if self.pid:
            self.kill_sshd()
            self.start_sshd()

    def power_on(self) -> None:
        """Boot; sshd accepts connections when it returns."""
        self._boot = Boot(self.name, self.home, self.folder, self.port, is_host=True)
        self.pid, self.own_pids = self._boot.pid, self._boot.pids
        self.link_up()
        self.start_sshd()

    def power_off(self) -> None:
        """All processes end at once, and nobody on the network is told."""
        self.link_down()
        if self._boot is not None:
            self._boot.end()
        self._boot, self.pid = None, 0

    def start_sshd(self) -> None:
        config = self.folder / "sshd_config"
        variables = [f'SetEnv {name}="{value}"\n' for name, value in python_path().items()]
        text = _CONFIG.format(port=SSH_PORT, key=self.folder / "host_key")
        config.write_text(text + "".join(variables), encoding="utf-8")
        self.run([program("sshd"), "-f", config, "-E", self.folder / "sshd.log"], cwd="/")
        wait_until(lambda: SSH_PORT in _listening(self.pid), f"sshd of {self.name} listens")

    def kill_sshd(self) -> None:
        """Kill sshd and the processes of its sessions; what runs in the sessions goes on."""
        for pid in self._sshd():
            _kill(pid)
        wait_until(lambda: SSH_PORT not in _listening(self.pid), f"sshd of {self.name} ends")

    def kill_sshd_sessions(self) -> None:
        """Kill the processes of sshd that serve a session, but not the one that listens."""
        listeners = proc.children(self.pid)
        for pid in self._sshd():
            if pid not in listeners:
                _kill(pid)

    def full_disk(self, path: Path | str) -> None:
        """Mount a file system without free space on the folder."""
        self.run(["mkdir", "-p", path])
        self.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", path])
        self.run(["dd", "if=/dev/zero", f"of={path}/filling", "bs=4k"], check=False)

    def free_disk(self, path: Path | str) -> None:
        """Undo `full_disk`."""
        self.run(["umount", "--lazy", path])

    def _sshd(self) -> list[int]:
        pids = [process.pid for process in self.processes()]
        return [pid for pid in pids if proc.read(pid, "comm").strip() == b"sshd"]


def _listening(pid: int) -> set[int]:
    """TCP ports on which somebody listens in the network namespace of a process."""
    rows = [line.split() for line in proc.read(pid, "net/tcp").decode().splitlines()[1:]]
    return {int(row[1].rpartition(":")[2], 16) for row in rows if row[3] == _LISTEN}


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
