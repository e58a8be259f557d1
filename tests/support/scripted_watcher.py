"""In place of `launcher.faults.watcher`: reports what a test writes into a file.

`python -m tests.support.scripted_watcher` is a launcher with it. The lines are those of
the watcher; LAUNCHER_TEST_FAULTS is the path.
"""

from __future__ import annotations

import os
import select
import sys
import time
from typing import Any

VARIABLE = "LAUNCHER_TEST_FAULTS"


def document(name: str, **more: Any) -> dict[str, Any]:
    """A fault that was confirmed now, as in docs/reference/faults.md."""
    now_s = time.time()
    return {
        "fault": name,
        "expectation": name,
        "kind": "rate",
        "place": None,
        "state": "active",
        "expected": "10 Hz",
        "seen": "nothing for 2 s",
        "value": None,
        "unit": "",
        "first_s": now_s - 1,
        "confirmed_s": now_s,
        "last_s": now_s,
        "healed_s": None,
        "count": 1,
        "lines": [],
        "message": None,
        "processes": [],
        "nodes": [],
        "topics": [],
        "cause": None,
        "rule": None,
        "follows": None,
        "incident": 1,
        "acknowledged": None,
        "muted": None,
        **more,
    }


def report(path: str) -> None:
    """Print the lines of the file, also those that come later, until standard input ends."""
    with open(path, encoding="utf-8") as file:
        while True:
            sys.stdout.write(file.read())
            sys.stdout.flush()
            if select.select([0], [], [], 0.02)[0] and not os.read(0, 1000):
                return


def main() -> int:
    if os.environ.get("LAUNCHER_TEST_SCRIPT"):
        report(os.environ[VARIABLE])
        return 0
    os.environ["LAUNCHER_TEST_SCRIPT"] = "1"
    from launcher.__main__ import main
    from launcher.faults import fault_watch

    fault_watch.MODULE = __spec__.name if __spec__ is not None else __name__
    return main()


if __name__ == "__main__":
    sys.exit(main())
