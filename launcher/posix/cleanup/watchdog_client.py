"""Starts the watchdog, which kills all processes of the run if the launcher is killed."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
from collections.abc import Callable

from launcher.posix import proc, spawn
from launcher.posix.cleanup import subreaper
from launcher.posix.reactor import Reactor

GOODBYE_S = 1.0  # a watchdog that does not end within this time is killed
MAX_STARTS = 3  # then the run continues without one
GROUP_VARIABLE = "LAUNCHER_CGROUP"
GROUPS = ("", "v2", "v1", "none")  # its values; with the first the watchdog decides


class WatchdogClient:
    """Starts the watchdog of a run, and another one if it is killed; `warn` takes one line."""

    def __init__(self, reactor: Reactor, run_id: str, warn: Callable[[str], object]) -> None:
        self._reactor = reactor
        self._run_id = run_id
        self._warn = warn
        self._started = 0
        self._before: list[int] = []
        self._sent: list[bytes] = []  # for another watchdog, too
        self._pid = self._pidfd = self._pipe = -1

    @property
    def pids(self) -> frozenset[int]:
        """The running watchdog, if there is one."""
        return frozenset({self._pid}) if self._pid > 0 else frozenset()

    def ensure(self) -> None:
        """Start it before the first process; it works even if we are killed while it starts."""
        if not self._started:
            # A shell may have started something before it became us by exec. What that leaves
            # behind is not ours: then we adopt nothing, since the origin of an orphan is unknown.
            self._before = proc.children(os.getpid())
            if not self._before:
                # Before the first process: no orphan of the run may be adopted by somebody else.
                subreaper.become()
            self._start()

    def keep(self, pid: int) -> None:
        """Let this helper process live if we are killed: it exits by itself then."""
        spawn.started.add(pid)
        self._send(b"keep %d\n" % pid)

    def prepare_end(self) -> None:
        """To be called when the run begins to end: the watchdog's part takes some milliseconds."""
        if b"leave\n" not in self._sent:
            self._send(b"leave\n")

    def _send(self, message: bytes) -> None:
        self._sent.append(message)
        self._write(message)

    def _write(self, message: bytes) -> None:
        if self._pid > 0:
            with contextlib.suppress(BrokenPipeError):  # it has been killed
                os.write(self._pipe, message)

    def _start(self) -> None:
        self._started += 1
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "watchdog.py")
        theirs, self._pipe = os.pipe()
        null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            self._pid = spawn.execute(
                (sys.executable, "-I", "-S", script, self._run_id, *self._about_us()),
                # No run id in its own environment: it must not find itself.
                env={k: v for k, v in os.environ.items() if k == "LD_LIBRARY_PATH"},
                streams=(theirs, null, null),
            )
            self._pidfd = os.pidfd_open(self._pid)
            self._reactor.add_reader(self._pidfd, self._exited)
            self._write(b"".join(self._sent))
        except OSError as error:
            os.close(self._pipe)
            self._pid = -1
            self._warn(f"cannot start the watchdog: {error.strerror}")
        finally:
            os.close(null)
            os.close(theirs)

    def _about_us(self) -> list[str]:
        return [str(os.getpid()), self._kind(), *map(str, self._before)]

    def _kind(self) -> str:
        kind = os.environ.get(GROUP_VARIABLE, "")
        if kind in GROUPS:
            return kind
        choices = ", ".join(GROUPS[1:])
        self._warn(f"{GROUP_VARIABLE}={kind} is ignored; its values are {choices}")
        return ""

    def _exited(self) -> None:
        self._close()
        is_restarted = self._started < MAX_STARTS
        if is_restarted:
            self._start()
        what = "restarting it" if is_restarted else "the run continues without one"
        self._warn(f"the watchdog was killed; {what}")

    def close(self) -> None:
        """Stop it in an orderly way, so that it kills nothing."""
        self._close()
        if self._started:
            subreaper.adopted()  # reaps those that were killed as leftovers
            subreaper.resign()

    def _close(self) -> None:
        if self._pid < 0:
            return
        self._reactor.remove(self._pidfd)
        self._write(b"goodbye\n")
        os.close(self._pipe)
        poll = select.poll()
        poll.register(self._pidfd, select.POLLIN)
        if not poll.poll(GOODBYE_S * 1000):  # it has been suspended
            os.kill(self._pid, signal.SIGKILL)
        spawn.reap(self._pidfd)
        os.close(self._pidfd)
        self._pid = -1
