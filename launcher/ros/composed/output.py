"""Standard output and error: each line with the member that has written it.

A line of a member is `RS index US text`, an event about it `RS index GS token words`. The first
line, `RS GS token`, tells the random token, so that no output of a program is taken for an event.
The lines of rcl come from C and have no such mark; they name their logger.
"""

from __future__ import annotations

import io
import os
import sys
import threading
from typing import Any

from launcher.ros.composed import current

RS, GS, US = "\x1e", "\x1d", "\x1f"
MOST_CHARACTERS = 65536  # of a line; a longer one is cut
_TOKEN = os.urandom(16).hex()
_lock = threading.Lock()


class MemberStream(io.TextIOBase):
    """Stands for a standard stream; what no member writes passes unchanged."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._partial: dict[int, str] = {}

    def write(self, text: str) -> int:
        one = current.member()
        if one is None:
            return int(self._stream.write(text))
        with _lock:
            *lines, rest = (self._partial.get(one.index, "") + text).split("\n")
            if len(rest) > MOST_CHARACTERS:
                lines, rest = [*lines, rest], ""
            self._partial[one.index] = rest
            self._put(one.index, lines)
        return len(text)

    def finish(self, index: int) -> None:
        """Write what the member has written after its last line."""
        with _lock:
            rest = self._partial.pop(index, "")
            self._put(index, [rest] if rest else [])

    def _put(self, index: int, lines: list[str]) -> None:
        if lines:
            self._stream.flush()
            text = "".join(f"{RS}{index}{US}{line}\n" for line in lines)
            encoding, errors = self._stream.encoding, self._stream.errors
            write_all(self._stream.fileno(), text.encode(encoding, errors))

    def flush(self) -> None:
        if current.member() is None:
            self._stream.flush()

    def writable(self) -> bool:
        return True

    def __getattribute__(self, name: str) -> Any:
        if name in ("buffer", "encoding", "errors", "fileno", "isatty", "mode", "name"):
            return getattr(object.__getattribute__(self, "_stream"), name)
        return object.__getattribute__(self, name)


def write_all(fd: int, data: bytes) -> None:
    """Nothing is lost but what nobody reads."""
    try:
        while data:
            data = data[os.write(fd, data) :]
    except OSError:
        return


def tell(index: int, *words: object) -> None:
    """An event about a member, on standard error, where the lines of its loggers go."""
    text = f"{RS}{index}{GS}{_TOKEN} {' '.join(map(str, words))}\n"
    write_all(2, text.encode())


def install() -> tuple[MemberStream, MemberStream]:
    """Before any program is started."""
    write_all(2, f"{RS}{GS}{_TOKEN}\n".encode())
    streams = MemberStream(sys.stdout), MemberStream(sys.stderr)
    sys.stdout, sys.stderr = streams
    sys.stdin = open(os.devnull)  # noqa: SIM115  (the real one has requests of the launcher)
    return streams
