"""A host without systemd: separate namespaces, and sshd."""

from __future__ import annotations

from pathlib import Path

from tests.support.hosts import clock
from tests.support.hosts.boot import Boot
from tests.support.hosts.keys import allow_login, make_key
from tests.support.hosts.network import Port
from tests.support.hosts.remote import Remote, kill
from tests.support.hosts.requirements import program
from tests.support.hosts.sockets import SSH_PORT, has_sshd
from tests.support.waiting import wait_until

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


class Host(Remote):
    """Root logs in by key; files are the machine's, but for home, /etc, /run, /tmp and /dev/shm."""

    def __init__(
        self, name: str, port: Port, folder: Path, public_key: str, *, clock_offset_s: float = 0.0
    ) -> None:
        super().__init__(name, port, folder, folder / "home")
        self.home.mkdir(mode=0o755, parents=True)
        self.variables.update(clock.variables(clock_offset_s))
        allow_login(self.home, public_key)
        self._boot: Boot | None = None
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
        """All processes end at once, and nothing is sent to the network."""
        self.link_down()
        if self._boot is not None:
            self._boot.end()
        self._boot, self.pid = None, 0

    def close(self) -> None:
        if self._boot is not None:
            self._boot.end()

    def start_sshd(self) -> None:
        config = self.folder / "sshd_config"
        text = _CONFIG.format(port=SSH_PORT, key=self.folder / "host_key")
        # Of several lines with SetEnv, sshd takes the first.
        pairs = " ".join(f'{name}="{value}"' for name, value in self.variables.items())
        config.write_text(text + (f"SetEnv {pairs}\n" if pairs else ""), encoding="utf-8")
        self.run([program("sshd"), "-f", config, "-E", self.folder / "sshd.log"], cwd="/")
        wait_until(lambda: has_sshd(self.pid), f"sshd of {self.name} listens")

    def kill_sshd(self) -> None:
        """Kill sshd and the processes of its sessions; what runs in the sessions goes on."""
        kill(self.sshd_pids())
        wait_until(lambda: not has_sshd(self.pid), f"sshd of {self.name} ends")
