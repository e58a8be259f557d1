"""The preparing process: imports what the nodes of a run need, and forks a process per request.

Called as `preparing.py FD`, a socket to the launcher (`preparing_process`); it ends with the
launcher. It starts no thread and never initialises rclpy. A forked process leaves through the last
lines of this file, so that no other frame of ours is below its program.
"""

from __future__ import annotations

import sys

if not getattr(sys.flags, "safe_path", False):
    # Our folder would hide modules of the same names. The interpreter may have cached it.
    sys.path_importer_cache.pop(sys.path.pop(0), None)

import os

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable


def _program() -> Callable[[], object]:
    """Serve the launcher; returns only in a forked process, with the function that it runs."""
    root = os.path.abspath(__file__).rpartition("/launcher/run/warm/")[0]
    sys.path.append(root)
    from launcher.run.warm.preparing_service import serve

    sys.path.remove(root)
    return serve(int(sys.argv[1]))


_program()()
