"""Starts the process that asks the nodes of a domain whether they answer.

It is launcher.ros.helpers.responsiveness; it ends with its input.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator, Mapping

from launcher.base import strict_json
from launcher.posix import spawn
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.reactor import Reactor
from launcher.run.helpers.popen import last_line, start_module, wait_or_kill
from launcher.run.helpers.programs import RESPONSIVENESS
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


GOODBYE_S = 2.0


class ResponsivenessHelper:
    """`report` is called with each report, and `ended` with its last error line."""

    def __init__(
        self,
        reactor: Reactor,
        env: Mapping[str, str],
        report: Callable[[dict[str, Any]], None],
        ended: Callable[[str], None],
    ) -> None:
        self._reactor = reactor
        self._report = report
        self._ended = ended
        self._sent = self._unsent = self._received = b""
        self._errors = os.memfd_create("errors")
        # Nothing to clean up, but where rmw_fastrtps limits discovery to this machine.
        env = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4", **env}
        env.pop(RUN_ID_VARIABLE, None)
        try:
            self._process = start_module(
                [RESPONSIVENESS],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=env,
                bufsize=0,
            )
        except OSError:
            os.close(self._errors)
            raise
        self.pid = self._process.pid
        spawn.started.add(self.pid)
        assert self._process.stdin is not None and self._process.stdout is not None
        self._in, self._out = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._in, False)
        os.set_blocking(self._out, False)
        reactor.add_reader(self._out, self._readable)

    def watch(self, nodes: Mapping[str, Process], *, expected: bool) -> None:
        """Send the list if it is not the last one; what the pipe does not take, the next time.

        Nodes that are expected to answer are reported even if they never have.
        """
        entries = [
            {"name": one.name, "pid": one.child.pid, "node": node, "expected": expected}
            for node, one in nodes.items()
            if one.child is not None
        ]
        line = strict_json.packed(entries).encode() + b"\n"
        if line != self._sent and not self._unsent:
            self._sent = self._unsent = line
        if self._unsent:
            try:
                self._unsent = self._unsent[os.write(self._in, self._unsent) :]
            except (BlockingIOError, BrokenPipeError):
                return  # it is starting, or has ended, which its output tells

    def _readable(self) -> None:
        chunk = os.read(self._out, 65536)
        if not chunk:
            why = last_line(self._errors)
            self.close()
            self._ended(why)
            return
        *reports, self._received = (self._received + chunk).split(b"\n")
        for report in _decoded(reports):
            self._report(report)

    def close(self) -> None:
        self._reactor.remove(self._out)
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        wait_or_kill(self._process, GOODBYE_S)
        spawn.started.discard(self.pid)
        self._process.stdout.close()
        os.close(self._errors)


def _decoded(reports: list[bytes]) -> Iterator[dict[str, Any]]:
    """The reports among its lines; Fast DDS may print others."""
    for line in reports:
        try:
            found = strict_json.unpacked(line)
        except ValueError:
            continue
        if isinstance(found, dict):
            yield found
