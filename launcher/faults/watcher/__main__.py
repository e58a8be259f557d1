"""`python -m launcher.faults.watcher SETTINGS`: see the package."""

from __future__ import annotations

import contextlib
import queue
import sys
import threading
from typing import Any

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.faults.watcher.watching import FaultWatcher, WatchSettings
from launcher.posix import dispositions
from launcher.posix.stdio import keep_for_messages

_saying = threading.Lock()


def say(**values: object) -> None:
    """A line for the launcher, which may be gone."""
    with _saying, contextlib.suppress(OSError):
        sys.stdout.write(strict_json.packed(values, default=str) + "\n")
        sys.stdout.flush()


def _read(requests: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in sys.stdin:
        request = strict_json.unpacked(line)
        if isinstance(request, dict):
            requests.put(request)
    requests.put({"do": "end"})


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # it ends with the launcher
    settings = WatchSettings(**strict_json.unpacked(sys.argv[1]))
    requests: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(requests,), daemon=True, name="requests").start()
    try:
        FaultWatcher(settings, requests, say).run()
    except LauncherError as error:
        say(mistake=error.render())


if __name__ == "__main__":
    main()
