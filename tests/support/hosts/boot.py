"""The first process of a computer, which makes its namespaces."""

from __future__ import annotations

import os
import re
import subprocess
import uuid
from pathlib import Path

from tests.support.children import children, is_alive
from tests.support.hosts.network import Port
from tests.support.hosts.requirements import program
from tests.support.waiting import wait_until

SHELL = "/bin/bash"

# $1 name, $2 folder. /etc is an overlay: its files are the machine's, until they are changed.
_MOUNT = """set -e
exec 3>&1 >&2
hostname "$1"
mount -t tmpfs -o mode=1777 tmpfs /dev/shm
mount -t tmpfs -o mode=755 tmpfs "$2/etc"
mkdir "$2/etc/upper" "$2/etc/work"
mount -t overlay -o "lowerdir=/etc,upperdir=$2/etc/upper,workdir=$2/etc/work" overlay /etc
cp "$2"/files/* /etc/
"""
_MOUNT_OF_HOST = """
mount -t tmpfs -o mode=1777 tmpfs /tmp
mount -t tmpfs -o mode=755 tmpfs /run
mkdir /run/lock /run/sshd
mount --bind "$2/boot_id" /proc/sys/kernel/random/boot_id
"""
# The first process of a pid namespace must collect orphans; dash and bash do while they wait.
_STAY = """
sleep infinity 3>&- &
echo ready >&3
exec 3>&-
while :; do wait $! || true; sleep infinity & done
"""


class Boot:
    """Running from here on until `end`."""

    def __init__(self, name: str, home: Path, folder: Path, port: Port, *, is_host: bool) -> None:
        (folder / "etc").mkdir(exist_ok=True)
        _write_etc(folder / "files", name, home)
        (folder / "boot_id").write_text(f"{uuid.uuid4()}\n")
        self._log = folder / "boot.log"
        self._process = self._start(name, folder, port, is_host)
        self._wait_until_ready()
        outer = self._process.pid
        self.pid = children(outer)[0] if is_host else outer
        self.pids = {outer, self.pid, *children(self.pid)}

    def end(self) -> None:
        """All processes end at once; no process of a host outlives the first one."""
        self._process.kill()
        self._process.wait()
        wait_until(lambda: not is_alive(self.pid), "the first process ends")

    def _start(self, name: str, folder: Path, port: Port, is_host: bool) -> subprocess.Popen[bytes]:
        kinds = ["--uts", "--ipc", "--mount", "--propagation", "private"]
        if is_host:
            kinds += ["--pid", "--fork", "--mount-proc", "--kill-child=KILL"]
        script = _MOUNT + (_MOUNT_OF_HOST if is_host else "") + _STAY
        command = ["nsenter", f"--net={port.path}", "unshare", *kinds]
        with open(self._log, "wb") as log:
            return subprocess.Popen(
                [*command, "sh", "-c", script, "sh", name, str(folder)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log,
                env={"PATH": os.path.dirname(program("sh") or "") + ":/usr/sbin:/usr/bin:/sbin"},
                cwd="/",
                start_new_session=True,
            )

    def _wait_until_ready(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stdout:
            line = stdout.readline()
        if line != b"ready\n":
            self._process.wait()
            raise AssertionError(f"the host did not start: {self._log.read_text()}")


def _write_etc(folder: Path, name: str, home: Path) -> None:
    """Files of /etc that differ from the machine's; root has the home, and no password."""
    folder.mkdir(exist_ok=True)
    machine_id = folder / "machine-id"
    if not machine_id.exists():
        machine_id.write_text(f"{uuid.uuid4().hex}\n")
    (folder / "hostname").write_text(f"{name}\n")
    (folder / "hosts").write_text(f"127.0.0.1 localhost\n127.0.1.1 {name}\n")
    passwd = Path("/etc/passwd").read_text()
    root = f"root:x:0:0:root:{home}:{SHELL}"
    (folder / "passwd").write_text(re.sub(r"^root:.*$", root, passwd, flags=re.MULTILINE))
    shadow = Path("/etc/shadow").read_text()
    (folder / "shadow").write_text(re.sub(r"^root:[^:]*", "root:*", shadow, flags=re.MULTILINE))
    (folder / "shadow").chmod(0o640)
