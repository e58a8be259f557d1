"""Starts the process that looks at the ROS graph for a run (launcher.ros.ready).

One for each domain. It is restarted once if it dies, and ends when nothing has been asked of it for
a while.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Mapping

from launcher.base import strict_json
from launcher.base.model.record import as_dict
from launcher.base.model.supervision import Fact
from launcher.base.text import how_it_ended
from launcher.posix import spawn
from launcher.posix.reactor import Reactor, Timer
from launcher.run.helpers.popen import last_line, start_module, wait_or_kill
from launcher.run.helpers.programs import READY

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    Tell = Callable[[bool, str], None]  # whether it holds, and what is seen instead

MAX_STARTS = 2
IDLE_S = 10.0
GOODBYE_S = 2.0  # one that does not exit at EOF of its input is killed after this


class GraphFacts:
    """`warn` is called with texts for the user."""

    def __init__(self, reactor: Reactor, warn: Callable[[str], None]) -> None:
        self._reactor = reactor
        self._warn = warn
        self._helpers: dict[str, _Helper] = {}
        self._of_number: dict[int, _Helper] = {}
        self._last = 0

    def watch(self, fact: Fact, env: Mapping[str, str], since_s: float, tell: Tell) -> int:
        """Tell from now on what is seen of a fact, in the domain of this environment."""
        domain = env.get("ROS_DOMAIN_ID") or "0"
        if domain not in self._helpers or self._helpers[domain].has_left:
            self._helpers[domain] = _Helper(self._reactor, self._warn, env)
        self._last += 1
        self._of_number[self._last] = self._helpers[domain]
        request = {"watch": self._last, "fact": as_dict(fact), "since_s": since_s}
        self._helpers[domain].watch(self._last, request, tell)
        return self._last

    def unwatch(self, number: int) -> None:
        self._of_number.pop(number).unwatch(number)

    def close(self) -> None:
        for helper in self._helpers.values():
            helper.close()


class _Helper:
    """One process; a request is kept until it is withdrawn, for a process that is restarted."""

    def __init__(
        self, reactor: Reactor, warn: Callable[[str], None], env: Mapping[str, str]
    ) -> None:
        self._reactor = reactor
        self._warn = warn
        # Nothing to clean up, but where rmw_fastrtps limits discovery to this machine.
        self._env = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4", **env}
        self._requests: dict[int, tuple[dict[str, Any], Tell]] = {}
        self._starts = 0
        self._timer: Timer | None = None
        self.has_left = False
        self._process: subprocess.Popen[bytes] | None = None
        self._start()

    def _start(self) -> None:
        self._starts += 1
        self._partial = self._unsent = b""
        self._errors = os.memfd_create("ready-errors", os.MFD_CLOEXEC)
        try:
            process = start_module(
                [READY],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=self._env,
                bufsize=0,
            )
        except OSError as error:
            os.close(self._errors)
            self._warn(f"nothing is known of the ROS graph: {error.strerror}")
            return
        self._process = process
        spawn.started.add(process.pid)
        assert process.stdin is not None and process.stdout is not None
        self._in, self._out = process.stdin.fileno(), process.stdout.fileno()
        os.set_blocking(self._in, False)
        os.set_blocking(self._out, False)
        self._reactor.add_reader(self._out, self._readable)
        for request, _ in self._requests.values():
            self._write(request)

    def watch(self, number: int, request: dict[str, Any], tell: Tell) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._requests[number] = (request, tell)
        if self._process is None:
            self._reactor.call_later(0, self._tell_unknown)
        self._write(request)

    def unwatch(self, number: int) -> None:
        del self._requests[number]
        self._write({"unwatch": number})
        if not self._requests:
            self._timer = self._reactor.call_later(IDLE_S, self._leave)

    def _leave(self) -> None:
        """Let it end; another one is started when it is needed again."""
        if self._process is not None and self._process.stdin is not None:
            self.has_left = True
            self._reactor.remove(self._in)
            self._process.stdin.close()

    # ---- writing, without waiting for a process that does not read

    def _write(self, message: dict[str, Any]) -> None:
        if self._process is None:
            return
        is_first = not self._unsent
        self._unsent += strict_json.packed(message).encode() + b"\n"
        if is_first and self._flush():
            self._reactor.add_writer(self._in, self._writable)

    def _writable(self) -> None:
        if not self._flush():
            self._reactor.remove(self._in)

    def _flush(self) -> bool:
        """Write what the pipe takes; whether something is left."""
        try:
            self._unsent = self._unsent[os.write(self._in, self._unsent) :]
        except BlockingIOError:
            return True
        except BrokenPipeError:
            self._unsent = b""  # the end of its output is noticed as well
        return bool(self._unsent)

    # ---- reading

    def _readable(self) -> None:
        chunk = os.read(self._out, 65536)
        if not chunk:
            self._died()
            return
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        for line in lines:
            if not line.startswith(b"{"):
                continue  # Fast DDS prints some of its warnings to standard output
            seen = strict_json.unpacked(line)
            if seen["watch"] in self._requests:
                self._requests[seen["watch"]][1](seen["holds"], seen["text"])

    def _died(self) -> None:
        assert self._process is not None
        self._process.kill()  # it has closed its output
        code = self._process.wait()
        line = last_line(self._errors)
        self._release()
        if self.has_left:
            return
        how = how_it_ended(code)
        reason = f"{how}: {line}" if line else how
        is_restarted = self._starts < MAX_STARTS
        what = "restarting it" if is_restarted else "waits for ROS facts end by their timeouts"
        self._warn(f"the process that looks at the ROS graph died ({reason}); {what}")
        if is_restarted:
            self._start()
        else:
            self._tell_unknown()

    def _tell_unknown(self) -> None:
        for _, tell in list(self._requests.values()):
            tell(False, "it is not known: what looks at the ROS graph has died")

    def _release(self) -> None:
        process = self._process
        assert process is not None and process.stdin is not None and process.stdout is not None
        self._reactor.remove(self._out)
        self._reactor.remove(self._in)
        process.stdin.close()
        process.stdout.close()
        os.close(self._errors)
        spawn.started.discard(process.pid)
        self._process = None

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        if self._process is None:
            return
        assert self._process.stdin is not None
        if not self.has_left:
            self._reactor.remove(self._in)
        self._process.stdin.close()
        wait_or_kill(self._process, GOODBYE_S)
        self._release()
