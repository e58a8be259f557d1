"""A robot: real systemd in a container, with sshd, and a user who is not root."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

from launcher.posix import proc
from tests.support.hosts.cgroups import group_folders
from tests.support.hosts.leftovers import processes_in
from tests.support.hosts.network import Port
from tests.support.hosts.remote import Remote
from tests.support.hosts.robot_files import shared_folders, write_files
from tests.support.hosts.sockets import has_sshd
from tests.support.hosts.tool import TIMEOUT_S
from tests.support.hosts.tree import USER, USER_ID, tree
from tests.support.waiting import wait_until

# $1 tree, $2 folder; then control groups, `--`, and the command.
_START = """set -e
tree=$1 folder=$2
shift 2
mount -t overlay -o "lowerdir=$tree,upperdir=$folder/upper,workdir=$folder/work" overlay \\
  "$folder/root"
while [ "$1" != -- ]; do
  mkdir -p "$1"
  echo $$ > "$1/cgroup.procs"
  shift
done
shift
exec "$@"
"""
# Never start systemd without a separate tree: it would empty the machine's /tmp.
_CONTAINER = ("--boot", "--register=no", "--keep-unit", "--console=pipe", "--link-journal=no")
_UNCHANGED = ("--resolv-conf=off", "--timezone=off")


class Robot(Remote):
    """Root and the user `robot` log in by key; the user has a `systemd --user` from boot on.

    Of the machine it sees the environment of the tests and the checkout, both read-only. What it
    writes is there after `power_off` and `power_on`, too.
    """

    user = USER

    def __init__(self, name: str, port: Port, folder: Path, public_key: str) -> None:
        super().__init__(name, port, folder, Path("/root"))
        for part in ("upper", "work", "root"):
            (folder / part).mkdir(mode=0o755, parents=True)
        self.public_key = write_files(folder / "upper", name, public_key)
        self._nspawn: subprocess.Popen[bytes] | None = None
        self.power_on()

    @property
    def console(self) -> str:
        """What systemd wrote while it booted."""
        return (self.folder / "console.log").read_text(encoding="utf-8", errors="replace")

    @property
    def root(self) -> Path:
        """Its file system, as this machine sees it while the robot is on."""
        return Path(f"/proc/{self.pid}/root")

    def power_on(self) -> None:
        """Boot; root and the user can log in when it returns."""
        self._nspawn = self._start()
        wait_until(self._has_booted, f"{self.name} boots")
        self.link_up()

    def power_off(self) -> None:
        """All processes end at once, and nothing is sent to the network."""
        self.link_down()
        if self.pid:
            # Without its systemd the container ends; without nspawn, it would go on.
            os.kill(self.pid, signal.SIGKILL)
        if self._nspawn is not None:
            self._nspawn.wait(TIMEOUT_S)
        self._nspawn, self.pid = None, 0

    def new_host_key(self) -> None:
        """Give sshd another key, as after a new installation; `public_key` is the new one."""
        key = "/etc/ssh/ssh_host_ed25519_key"
        self.run(["rm", "-f", key, f"{key}.pub"])
        self.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", key])
        self.run(["systemctl", "restart", "ssh"])
        self.public_key = " ".join(self.run(["cat", f"{key}.pub"]).stdout.split()[:2])

    def close(self) -> None:
        if self._nspawn is not None:
            self._nspawn.wait(TIMEOUT_S)

    def _start(self) -> subprocess.Popen[bytes]:
        groups = group_folders(self.port.namespace)
        start = ("unshare", "--mount", "--propagation", "private", "sh", "-c", _START, "sh")
        words = (*start, tree(), self.folder, *groups, "--", *self._container())
        with open(self.folder / "console.log", "wb") as log:
            return subprocess.Popen(
                [str(word) for word in words],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd="/",
                env={"PATH": os.defpath + ":/usr/sbin:/sbin", "LANG": "C.UTF-8"},
                start_new_session=True,
            )

    def _container(self) -> list[str]:
        return [
            *("systemd-nspawn", "--quiet", *_CONTAINER, *_UNCHANGED),
            f"--directory={self.folder / 'root'}",
            f"--machine={self.name}",
            f"--network-namespace-path={self.port.path}",
            *(f"--bind-ro={folder}" for folder in shared_folders()),
        ]

    def _has_booted(self) -> bool:
        assert self._nspawn is not None
        assert self._nspawn.poll() is None, f"{self.name} did not start: {self.console}"
        self.pid = self.pid or self._find_systemd()
        if not self.pid or not has_sshd(self.pid):
            return False
        self.own_pids = {self.pid}
        is_open = not (self.root / "run/nologin").exists()  # for users who are not root
        return is_open and (self.root / f"run/user/{USER_ID}/bus").exists()

    def _find_systemd(self) -> int:
        """The pid of the container's first process."""
        for pid in processes_in(self.port.namespace):
            if proc.status_field(pid, "NSpid").endswith("\t1"):
                return pid
        return 0
