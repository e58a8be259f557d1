"""`analyze [RUN]`: show where the time of a start-up went."""

from __future__ import annotations

import os
from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode, UsageError
from launcher.base.option import DEBUG, JSON, option
from launcher.base.verb_table import VERBS
from launcher.posix.stdio import print_text

COMMAND = Command(
    "analyze",
    VERBS["analyze"],
    arguments=(option("[RUN]"),),
    about="""\
Show when each process was asked for, started and ready, which ones took longest, and the chain of
waits that the start-up took. RUN is the id, pid or target of a running launch, or the log folder of
a run; default: the newest run of this log folder.""",
    options=(JSON, DEBUG),
)


def main(words: Sequence[str]) -> int:
    """Print the report on the run that `words` name; the exit code."""
    parsed = COMMAND.parse(words)
    from launcher.launch.analyze import timeline, timeline_report

    folder = _folder(parsed.run)
    found = timeline.read(folder)
    if not found.processes:
        raise UsageError(f"no process has been started so far: {folder}")
    if parsed.json:
        from launcher.posix.json_output import print_document

        print_document(timeline_report.document(found))
    else:
        columns = _columns()
        print_text("\n".join(timeline_report.lines(found, columns)))
    return ExitCode.OK


def _columns() -> int:
    try:
        return os.get_terminal_size(1).columns
    except OSError:
        return 100


def _folder(run: str | None) -> str:
    """The log folder of the run; LauncherError."""
    from launcher.output.logs.run_directory import EVENTS, current_root

    root = current_root(os.environ)
    if run is None:
        folder = os.path.realpath(os.path.join(root, "latest"))
        if not os.path.isfile(os.path.join(folder, EVENTS)):
            raise UsageError(f"there is no run in {root}", hint="name the log folder of a run")
        return folder
    for folder in (run, os.path.join(root, run)):
        if os.path.isfile(os.path.join(folder, EVENTS)):
            return os.path.realpath(folder)
    return _folder_of_active(run)


def _folder_of_active(run: str) -> str:
    from launcher.control.active_runs import find_run

    with find_run(run, read_only=True).connect() as connection:
        folder = connection.hello["run"]["log_dir"]
    if folder is None:
        raise UsageError(f"run {run} has no log files", hint="run it without --no-log-files")
    return str(folder)
