"""The values of the options of a watched run."""

from __future__ import annotations

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.run import Run

MAX_FILES = 500  # they are in one word of a command line


def check(options: RunOptions) -> None:
    """UsageError for options that exclude each other; LauncherError for mistakes in the file."""
    if not options.control:
        raise UsageError("--expect and --watchful need the control socket: without --no-control")
    from launcher.packages.absent_ros import require

    require("--watchful" if options.expect is None else "--expect", {})
    if options.expect is not None:
        _check_file(options.expect)


def with_expectations_beside(options: RunOptions, launch_file: str) -> RunOptions:
    """With the file beside the launch file, unless one is given; LauncherError for its mistakes."""
    from launcher.smoke.preflight.loader import beside

    path = None if options.expect is not None else beside(launch_file)
    if path is None:
        return options
    _check_file(str(path))
    return replace(options, expect=str(path))


def _check_file(path: str) -> None:
    from launcher.smoke.preflight import loader

    loader.load(path)


def settings_of(run: Run) -> dict[str, Any]:
    """The settings of `launcher.faults.watcher`."""
    assert run.socket is not None
    return {
        "socket": run.socket,
        "run_folder": run.log_dir,
        "launch_file": run.launched.target,
        "files": _files(run)[:MAX_FILES],
        "arguments": list(run.launched.arguments),
        "expect": run.options.expect,
    }


def _files(run: Run) -> list[str]:
    """What the launch file has included and read; nothing of a run that cannot be reloaded."""
    if not hasattr(run.core, "launch_files"):
        return []
    try:
        files: list[str] = run.core.launch_files()
    except LauncherError:  # composed nodes
        return []
    return files
