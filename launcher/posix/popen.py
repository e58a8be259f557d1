"""The start of a process by `subprocess`, for what `posix_spawn` cannot do.

That is a working directory, and a new session where Python was built for an old C library.
"""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence

from launcher.posix import dispositions, open_files


def by_subprocess(
    words: Sequence[str],
    env: Mapping[str, str],
    streams: tuple[int, int, int],
    cwd: str | None,
    inherited: Sequence[int],
) -> int:
    """As `spawn.execute`, but with a ValueError for what it reports as EINVAL."""

    def restore() -> None:  # posix_spawn does this by itself
        dispositions.reset()
        open_files.lower()

    stdin, stdout, stderr = streams
    popen = subprocess.Popen(
        words,
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        env=env,
        cwd=cwd,
        pass_fds=inherited,
        start_new_session=True,
        preexec_fn=restore if open_files.is_raised() or not dispositions.are_default() else None,
    )
    popen.returncode = 0  # it is reaped by its pidfd: Popen must not wait for it
    return popen.pid
