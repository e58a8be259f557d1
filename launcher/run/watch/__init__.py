"""Watches the files that processes have loaded; its own process, `python -m launcher.run.watch`.

`watched_programs` finds the files, `folders` waits for changes and for their end, `file_checks`
compares and compiles, `watched` says what a change means. The supervisor's side is `watching`.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions


def check(options: RunOptions) -> None:
    """UsageError without the library that watches files."""
    from launcher.packages.extras import require

    require("watch", "watchfiles", "watching files")
