"""Starts colcon and reads its events."""

from __future__ import annotations

import os
import select
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import IO, Any

import launcher
from launcher.base import strict_json
from launcher.posix import proc
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.colcon import build_signals, descendants

Event = dict[str, Any]

_ROOT = os.path.dirname(os.path.dirname(os.path.abspath(launcher.__file__)))
# Not `-m`: the launcher may run from its checkout, which is not on the path of another working
# directory, and files in that directory (the empty entry) may hide modules of Python.
_PROGRAM = (
    "import sys; sys.path[:] = [*filter(None, sys.path), {root!r}]; "
    "from launcher.workspace.building.colcon import colcon_process; sys.exit(colcon_process.main())"
)
_TICK_S = 0.2


class Colcon:
    """A running colcon. As a context manager it kills what is left when the block is left.

    What colcon writes to stderr goes to the file `errors`; without one it has our terminal.
    """

    def __init__(
        self,
        place: Place,
        words: Sequence[str],
        env: Mapping[str, str],
        *,
        lock: int,
        errors: IO[bytes] | None,
    ) -> None:
        descendants.adopt()
        self._others = proc.children(os.getpid())
        self._errors = errors
        events, theirs = os.pipe()
        life, self._life = os.pipe()
        command = [sys.executable, "-c", _PROGRAM.format(root=_ROOT), str(theirs), str(life)]
        try:
            self._process = subprocess.Popen(
                [*command, "--log-base", place.log, *words],
                cwd=place.root,
                env=dict(env),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL if errors else None,
                stderr=errors,
                pass_fds=(theirs, life, lock),
                start_new_session=True,
            )
        except BaseException:
            os.close(events)
            os.close(self._life)
            raise
        finally:
            os.close(theirs)
            os.close(life)
        self._events = os.fdopen(events, "rb", buffering=0)

    def __enter__(self) -> Colcon:
        return self

    def __exit__(self, *_: object) -> None:
        """End colcon and everything that it has started, if it runs."""
        with build_signals.ignored():
            os.close(self._life)
            self._process.wait()
            descendants.kill(self._others)  # colcon itself may have been killed
            self._events.close()

    def events(self) -> Iterator[Event | None]:
        """The events as they happen; None about every fifth of a second without any."""
        rest = b""
        while True:
            if not select.select([self._events], [], [], _TICK_S)[0]:
                yield None
                continue
            data = self._events.read(1 << 16)
            if not data:
                return
            *lines, rest = (rest + data).split(b"\n")
            yield from map(strict_json.unpacked, lines)

    def wait(self) -> int:
        """The exit code, after the last event."""
        return self._process.wait()

    def errors(self) -> str:
        """What colcon itself has written to stderr, if that was not the terminal."""
        if self._errors is None:
            return ""
        self._errors.seek(0)
        return self._errors.read().decode(errors="replace").strip()
