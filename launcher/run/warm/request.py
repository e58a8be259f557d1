"""One warm start: what is asked of the preparing process, and the descriptors of the child."""

from __future__ import annotations

import _socket
import contextlib
import os

from launcher.posix import spawn
from launcher.run.stacks import py_spy

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.packages.python_program import PythonProgram
    from launcher.run.processes.process import Process


class WarmStart:
    """`cwd` is where it runs, `folder` the first entry of its `sys.path`.

    The descriptors are open from `open` on; `close` closes ours, which ends a process that has
    not begun yet.
    """

    def __init__(
        self,
        process: Process,
        program: PythonProgram,
        settings: spawn.StartSettings,
        *,
        cwd: str,
        folder: str,
    ) -> None:
        self.process = process
        self.settings = settings
        self.folder = folder
        self.is_withdrawn = False
        self._program = program
        self._cwd = cwd
        self._streams: spawn.Streams | None = None
        self._status = -1
        self._theirs: list[int] = []

    def to_prepare(self) -> dict[str, str]:
        script = self._program.script and os.path.join(self._cwd, self._program.script)
        return {"script": script, "module": self._program.module, "folder": self.folder}

    def content(self, number: int) -> dict[str, Any]:
        program, limits = self._program, self.process.spec.limits
        settings: list[str] = []
        if limits is not None:
            from launcher.posix.limits import settings_of

            settings = list(settings_of(limits))
        return {
            "start": number,
            "script": program.script,
            "module": program.module,
            "words": program.words,
            "interpreter": os.path.join(self._cwd, program.interpreter),
            "orig_argv": program.orig_argv,
            "executed": program.executed,
            "title": program.orig_argv,
            "folder": self.folder,
            "cwd": self._cwd,
            "limits": settings,
            "answers_stacks": not py_spy.is_usable(),
            "environment": dict(self.settings.env),
        }

    def open(self) -> list[int]:
        """The descriptors for the child: three streams, and the status; OSError."""
        streams = spawn.open_streams(self.process.spec, self.settings)
        self._streams = streams
        self._theirs = list(streams.theirs)
        ours, theirs = _socket.socketpair(
            _socket.AF_UNIX, _socket.SOCK_STREAM | _socket.SOCK_CLOEXEC
        )
        self._status = ours.detach()
        self._theirs.append(theirs.detach())
        spawn.keep_free(max(*self._theirs, self._status), spawn.FOR_PROCESSES)
        return [*streams.standard, self._theirs[-1]]

    def close_theirs(self) -> None:
        for fd in self._theirs:
            os.close(fd)
        self._theirs = []

    def child(self, pid: int, pidfd: int) -> spawn.Child:
        """The child, which begins now."""
        assert self._streams is not None
        with contextlib.suppress(OSError):  # it was killed meanwhile
            os.write(self._status, b"g")
        streams = self._streams
        child = spawn.Child(pid, streams.ours, pidfd, streams.stdin, self._status)
        self._streams, self._status = None, -1
        return child

    def close(self) -> None:
        self.close_theirs()
        if self._streams is not None:
            self._streams.close_ours()
            self._streams = None
        if self._status >= 0:
            os.close(self._status)
            self._status = -1
