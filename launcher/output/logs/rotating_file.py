"""A log file that is renamed to `path.1` and started again at a size limit."""

from __future__ import annotations

import contextlib
import os

from launcher.posix.spawn import FOR_FILES, keep_free

LIMIT_BYTES = 10 * 1024 * 1024
BACKUPS = 3


class RotatingFile:
    """Appends whole blocks to `path`; `path.1` is older, and so on. Raises only OSError."""

    def __init__(
        self, path: str, *, limit_bytes: int = LIMIT_BYTES, backups: int = BACKUPS
    ) -> None:
        self._path = path
        self._limit = limit_bytes
        self._backups = backups
        self._fd = self._open()
        self._size = os.fstat(self._fd).st_size

    def _open(self) -> int:
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
        fd = os.open(self._path, flags, 0o644)
        try:
            return keep_free(fd, FOR_FILES)
        except OSError:
            os.close(fd)
            raise

    def append(self, *blocks: bytes) -> None:
        """Write the blocks, after a rotation if they would exceed the limit."""
        is_one = len(blocks) == 1  # a restart writes three; `writev` takes longer for one
        size = len(blocks[0]) if is_one else sum(map(len, blocks))
        if self._size and self._size + size > self._limit:
            self._rotate()
        self._size += size
        written = os.write(self._fd, blocks[0]) if is_one else os.writev(self._fd, blocks)
        if written < size:
            rest = b"".join(blocks)[written:]
            while rest:
                rest = rest[os.write(self._fd, rest) :]

    def _rotate(self) -> None:
        self.close()  # if opening fails, the descriptor must not be closed again
        for number in range(self._backups, 0, -1):
            newer = f"{self._path}.{number - 1}" if number > 1 else self._path
            with contextlib.suppress(FileNotFoundError):
                os.replace(newer, f"{self._path}.{number}")
        self._fd = self._open()
        self._size = os.fstat(self._fd).st_size

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
