"""Writes a growing file to its disk while it grows, and gives back the memory of what is there."""

from __future__ import annotations

import contextlib
import os

TYPE_CHECKING = False
if TYPE_CHECKING:
    from io import FileIO
    from queue import SimpleQueue
    from threading import Thread

KEPT_BYTES = 32 << 20  # the end of a file stays in memory; a small file stays there as a whole
_STEP_BYTES = 8 << 20


class WriteBehind:
    """Keeps all but the last `KEPT_BYTES` of a file out of the page cache (posix_fadvise(2)).

    For large files that are written once. By default the kernel keeps each page, in place of what
    other programs read, until memory is full; a new page costs more than to copy into it, in
    virtual machines ten times as much, since the host provides it anew; and fsync(2) at the end
    waits for all that is not on the disk yet. A page that is given back is the next to be used.

    A thread gives the advice: that waits for a disk that is slow, as writing does not.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._ends: SimpleQueue[int | None] | None = None
        self._thread: Thread | None = None
        self._next = KEPT_BYTES + _STEP_BYTES

    def grown_to(self, size: int) -> None:
        """Call it after writing, with the bytes that the file has by now."""
        if size < self._next:
            return
        self._next = size + _STEP_BYTES
        if self._ends is None:
            self._start()
        assert self._ends is not None
        self._ends.put(size - KEPT_BYTES)

    def _start(self) -> None:
        from queue import SimpleQueue
        from threading import Thread

        self._ends = SimpleQueue()
        with contextlib.suppress(OSError, RuntimeError):  # out of descriptors, or of threads
            # a separate one: the file may be closed while the advice waits for the disk
            file = os.fdopen(os.dup(self._descriptor), "rb", buffering=0)
            thread = Thread(target=_advise, args=(file, self._ends), name="write-behind")
            thread.daemon = True
            thread.start()
            self._thread = thread

    def close(self) -> None:
        """Give no further advice. It does not wait, unlike `join`."""
        if self._ends is not None:
            self._ends.put(None)

    def join(self) -> None:
        """As `close`, and wait for the end of the last advice."""
        self.close()
        if self._thread is not None:
            self._thread.join()


def _advise(file: FileIO, ends: SimpleQueue[int | None]) -> None:
    """For pages that are not on the disk yet, the first advice only starts their writing."""
    with file, contextlib.suppress(OSError):  # a file system may refuse it
        while (end := ends.get()) is not None:
            if ends.empty():  # else the disk is slow, and the file has grown meanwhile
                os.posix_fadvise(file.fileno(), 0, end, os.POSIX_FADV_DONTNEED)
