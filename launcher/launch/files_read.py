"""Which files the evaluation of a launch file reads: its own ones, for `--watch`."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_SYSTEM = ("/proc/", "/sys/", "/dev/", "/usr/", "/etc/", "/lib", "/opt/ros/")


class _OpenRecorder:
    """Records each file that Python opens; the hook of the interpreter cannot be removed again."""

    def __init__(self) -> None:
        self.paths: dict[str, None] = {}
        self.is_on = False
        sys.addaudithook(self._record)

    def _record(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.is_on and event == "open":
            path, mode, flags = arguments
            is_read = (flags or 0) & os.O_ACCMODE == os.O_RDONLY and "w" not in (mode or "")
            if isinstance(path, (str, bytes, os.PathLike)) and is_read:
                self.paths[os.path.abspath(os.fsdecode(path))] = None


_recorders: list[_OpenRecorder] = []


@contextlib.contextmanager
def recording() -> Iterator[None]:
    """Within, files that are read are noted."""
    if not _recorders:
        _recorders.append(_OpenRecorder())
    (recorder,) = _recorders
    recorder.is_on = True
    try:
        yield
    finally:
        recorder.is_on = False


def files_read() -> list[str]:
    """The files of the user among those that were read so far, without modules."""
    own = (f"{tempfile.gettempdir()}/{name}" for name in ("launch_params_", "launcher-"))
    skipped = (*_SYSTEM, *own, sys.prefix, sys.base_prefix)
    return [
        path
        for one in _recorders
        for path in one.paths
        if not path.endswith((".py", ".pyc"))
        and not path.startswith(skipped)
        and os.path.isfile(path)
    ]
