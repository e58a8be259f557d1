"""What operator, hosts and robots have in common: a name, an address, and commands inside."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from launcher.posix import proc
from tests.support.hosts.entered import Entered
from tests.support.hosts.leftovers import processes_in
from tests.support.hosts.network import Port
from tests.support.hosts.tool import TIMEOUT_S, failure
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


@dataclass(frozen=True, slots=True, kw_only=True)
class Process:
    """A process of a computer; `pid` is the machine's number for it."""

    pid: int
    words: tuple[str, ...]


class Computer:
    """Runs commands in the namespaces of `pid`, the computer's first process."""

    kinds = ("-m", "-u", "-i", "-n")  # namespaces, as nsenter(1) calls them

    def __init__(self, name: str, port: Port, folder: Path, home: Path) -> None:
        self.name = name
        self.address = port.address
        self.folder = folder
        self.home = home
        self.pid = 0
        self.own_pids: set[int] = set()
        self.port = port
        self.variables = dict(python_path())

    def command(self, words: Sequence[object], cwd: Path | str | None = None) -> list[str]:
        """The words of a command that runs these words inside as root, in root's home."""
        enter = ("nsenter", f"--target={self.pid}", *self.kinds, "--")
        return [*enter, "env", "-C", str(cwd or self.home), "--", *map(str, words)]

    def environment(self, env: Mapping[str, str] | None = None) -> dict[str, str]:
        """The variables of a login there; nothing of those of the test."""
        login = {"HOME": str(self.home), "USER": "root", "LOGNAME": "root", "SHELL": "/bin/bash"}
        return {**login, "PATH": PATH, "LANG": "C.UTF-8", **self.variables, **(env or {})}

    def popen(
        self,
        words: Sequence[object],
        *,
        env: Mapping[str, str] | None = None,
        cwd: Path | str | None = None,
        **options: Any,
    ) -> Entered:
        """Start a command inside; options are those of subprocess.Popen."""
        return Entered(
            self.command(words, cwd),
            is_forked="-p" in self.kinds,
            env=self.environment(env),
            **{"text": True, "stdin": subprocess.DEVNULL, **options},
        )

    def run(
        self,
        words: Sequence[object],
        *,
        check: bool = True,
        input: str | None = None,
        timeout: float = TIMEOUT_S,
        **options: Any,
    ) -> subprocess.CompletedProcess[str]:
        """Run a command inside to its end; fails the test if it fails and `check` is set."""
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        stdin = subprocess.DEVNULL if input is None else subprocess.PIPE
        with self.popen(words, **{"stdin": stdin, **pipes, **options}) as process:
            try:
                out, err = process.communicate(input, timeout)
            except BaseException:
                process.kill()
                raise
        done = subprocess.CompletedProcess(process.args, process.returncode, out, err)
        assert not (check and done.returncode), f"{self.name}: {failure(done.args, done)}"
        return done

    def processes(self) -> list[Process]:
        """All processes of the computer but those that keep it running."""
        pids = set(processes_in(self.port.namespace)) - self.own_pids
        found = [(pid, _words(pid)) for pid in sorted(pids)]
        return [Process(pid=pid, words=words) for pid, words in found if words]

    def link_down(self) -> None:
        """Pull the plug: nothing announces it, and no packet passes."""
        self.port.set("down")

    def link_up(self) -> None:
        """Plug it in again; packets pass when it returns.

        The carrier comes up to a second later. Who looks for the address meanwhile would be
        refused with "No route to host".
        """
        self.port.set("up")
        wait_until(self.port.is_answered, f"{self.name} is on the network")


@cache
def python_path() -> Mapping[str, str]:
    """PYTHONPATH, if the environment of the tests has a launcher other than this one."""
    code = "import launcher; print(launcher.__file__)"
    done = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, text=True)
    is_this = Path(done.stdout.strip()).resolve() == REPOSITORY / "launcher/__init__.py"
    return {} if is_this else {"PYTHONPATH": str(REPOSITORY)}


def _words(pid: int) -> tuple[str, ...]:
    """Empty if it has ended. For a moment in exec, and while it ends, a process has none."""
    found = b""

    def is_known() -> bool:
        nonlocal found
        found = proc.read_memory(pid, "cmdline")
        return bool(found) or not proc.is_alive(pid)

    wait_until(is_known, f"the words of process {pid}")
    return tuple(os.fsdecode(found).rstrip("\0").split("\0")) if found else ()
