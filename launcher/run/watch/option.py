"""The value of the option `--watch`."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.options import RunOptions


def check(options: RunOptions) -> None:
    """UsageError without the library that watches files."""
    from launcher.packages.extras import require

    require("watch", "watchfiles", "watching files")
