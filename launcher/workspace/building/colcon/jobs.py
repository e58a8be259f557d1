"""Shares the processors among the packages that are built at the same time.

colcon builds as many packages at once as there are processors, and each ninja starts as many
compilers. With a job server, as that of make, each ninja runs one, and all of them together as many
more as there are processors.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping


@contextlib.contextmanager
def server(environ: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """The environment with a job server; unchanged if MAKEFLAGS is set or cannot name its pipe."""
    if environ.get("MAKEFLAGS") or " " in tempfile.gettempdir():
        yield dict(environ)
        return
    count = len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory(prefix="launcher-") as folder:
        path = os.path.join(folder, "jobs")
        os.mkfifo(path, 0o600)
        tokens = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        try:
            os.write(tokens, b"+" * (count - 1))
            yield {**environ, "MAKEFLAGS": f"-j{count} --jobserver-auth=fifo:{path}"}
        finally:
            os.close(tokens)
