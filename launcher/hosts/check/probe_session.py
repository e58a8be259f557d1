"""A probe on a host or on this machine, and what is said to it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Mapping
from importlib import resources
from typing import Any

from launcher.base import strict_json
from launcher.hosts.check.host_findings import CheckedHost, Clock, Needs
from launcher.hosts.failures import HostError, Problem, failure, no_ssh
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import SshConnection, quoted, set_python, setup_script, ssh_environment

PINGS = 8  # the quickest answer gives the best estimate of a clock
_END_S = 2.0
_SHELL = "launcher-check-user "  # printed by the shell there, before the name of the user
# Reads the program itself from standard input, and not a byte more.
_BOOT = """\
import sys
f = open(0, "rb", 0, closefd=False)
n, s = int(f.readline()), b""
while len(s) < n:
    s += f.read(n - len(s)) or sys.exit(1)
exec(compile(s, "launcher-check", "exec"))
"""


def program() -> bytes:
    """The source of the probe, preceded by its length."""
    source = (resources.files("launcher.hosts.check") / "probe.py").read_bytes()
    return b"%d\n" % len(source) + source


def remote_command(host: Host) -> list[str]:
    """Log in, print the user's name, and start the probe if there is a Python."""
    script = f'echo "{_SHELL}$(id -un)"; {setup_script(host)}{set_python(host)}'
    return SshConnection(host, None).session(f'{script}exec "$python" -c {quoted([_BOOT])}')


class ProbeSession:
    """Its output is read by `take`, line by line."""

    def __init__(self, name: str, host: Host | None, address: str, needs: Needs) -> None:
        self.name = name
        self.host = host
        self.address = address
        self.needs = needs
        self.user = ""
        self.facts: Mapping[str, Any] = {}
        self.error: HostError | None = None
        self.reached_s: float | None = None
        self._clocks: list[Clock] = []
        self._asked_s = 0.0
        self._rest = b""

    def start(self, request: Mapping[str, Any]) -> None:
        """Start it and send the request."""
        self._started_s = time.monotonic()
        here = [sys.executable, "-c", _BOOT]
        command = here if self.host is None else remote_command(self.host)
        self._errors = os.memfd_create("launcher-check", os.MFD_CLOEXEC)
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=ssh_environment(os.environ),
                start_new_session=True,
                bufsize=0,
            )
        except FileNotFoundError:
            assert self.host is not None
            raise no_ssh(self.host) from None
        self._write(program() + strict_json.packed(request).encode() + b"\n")

    def _write(self, data: bytes) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(data)
        except BrokenPipeError:
            return  # its output ends, too

    def ask(self, **request: object) -> None:
        self._write(strict_json.packed(request).encode() + b"\n")

    @property
    def fd(self) -> int:
        assert self._process.stdout is not None
        return self._process.stdout.fileno()

    @property
    def is_done(self) -> bool:
        """Whether it has answered all that it was asked, or never will."""
        return self.error is not None or len(self._clocks) >= PINGS

    # ---- what it says

    def take(self) -> list[dict[str, Any]]:
        """Read; its answers, without those about the clock. `error` is set at its end."""
        block = os.read(self.fd, 65536)
        now_s = time.time()
        *lines, self._rest = (self._rest + block).split(b"\n")
        answers = [self._answer(line, now_s) for line in lines]
        if not block:
            self._ended()
        return [answer for answer in answers if answer]

    def _answer(self, line: bytes, now_s: float) -> dict[str, Any]:
        text = line.decode("utf-8", "replace")
        if text.startswith(_SHELL):
            self.user = text.removeprefix(_SHELL).strip()
            self.reached_s = time.monotonic() - self._started_s
        try:
            answer = strict_json.loads(text)
        except ValueError:
            return {}  # of a login shell
        if not isinstance(answer, dict):
            return {}
        if "facts" in answer:
            self.facts = answer["facts"]
            self._ask_time()
        elif "pong" in answer:
            self._note_time(answer["time"], now_s)
            return {}
        return answer

    def _ask_time(self) -> None:
        self._asked_s = time.time()
        self.ask(ping=len(self._clocks))

    def _note_time(self, time_s: float, now_s: float) -> None:
        half_s = (now_s - self._asked_s) / 2
        self._clocks.append(Clock(offset_s=time_s - now_s + half_s, uncertainty_s=half_s))
        if len(self._clocks) < PINGS:
            self._ask_time()

    # ---- its end

    def _ended(self) -> None:
        if self.error is None:
            code = self._process.wait(_END_S)
            self._fail(os.pread(self._errors, 65536, 0).decode("utf-8", "replace"), code)

    def _fail(self, messages: str, code: int | None) -> None:
        host = self.host or Host(name=self.name, address=self.address)
        self.error = failure(host, messages, code)

    def give_up(self, timeout_s: float) -> None:
        """It has not answered in time."""
        assert self.host is not None
        text = f"no answer within {timeout_s:g} s"
        hint = f"is it switched on? A slow one needs more time: --timeout {2 * timeout_s:g}"
        self.error = HostError(self.host, Problem.TIMEOUT, text, hint=hint)

    def close(self) -> None:
        """End it; it does so by itself when its input ends."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        if not self.facts:
            self._process.kill()
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        os.close(self._errors)

    def member(self) -> CheckedHost:
        return CheckedHost(
            name=self.name,
            host=self.host,
            address=self.address,
            needs=self.needs,
            user=self.user,
            reached_s=self.reached_s,
            facts=self.facts,
            clock=min(self._clocks, key=lambda one: one.uncertainty_s, default=None),
            error=self.error,
        )
