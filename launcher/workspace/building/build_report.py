"""What a build prints at its end."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence

from launcher.base.errors import ExitCode, LauncherError
from launcher.base.model.events import signal_name
from launcher.base.program import program
from launcher.base.text import count, escape
from launcher.workspace.building.build_place import FULL_DISK_HINT, full_folders
from launcher.workspace.building.builder import BuildFailure, BuildOutcome
from launcher.workspace.building.explain import BuildOutput, explain
from launcher.workspace.building.sources.source_text import shown

_LINES = 15  # of what a tool has written


def show(outcome: BuildOutcome) -> ExitCode:
    """Print the failures and the summary; the exit code."""
    is_bad = outcome.code or outcome.failed
    full = full_folders(outcome.place) if is_bad else []
    if full:
        print(full_disk(full).render(), file=sys.stderr)
    for failure in outcome.failed:
        print(_render(failure, outcome, is_disk_full=bool(full)), file=sys.stderr)
    if outcome.code and not outcome.failed and not full:
        print(f"error: {_colcon_failed(outcome)}", file=sys.stderr)
    print(summary(outcome))
    if is_bad:
        return ExitCode.PROCESS_FAILED
    return ExitCode.USAGE if outcome.refused else ExitCode.OK


def _colcon_failed(outcome: BuildOutcome) -> str:
    if outcome.code < 0:
        return f"colcon was killed by {signal_name(-outcome.code)}; the next build continues"
    return f"colcon failed: {escape(outcome.errors) or f'exit code {outcome.code}'}"


def full_disk(folders: Sequence[str]) -> LauncherError:
    where = ", ".join(map(shown, folders))
    return LauncherError(f"No space left on device: {where}", hint=FULL_DISK_HINT)


def _render(failure: BuildFailure, outcome: BuildOutcome, *, is_disk_full: bool = False) -> str:
    """The failure of a package: its cause, or its last lines, and where the rest is.

    A full disk, which is reported before, is the cause of all that has no place in a file.
    """
    package = failure.package
    text = output_of(package.folder, failure.log, failure.stderr)
    build = os.path.join(outcome.place.build, package.name)
    error = explain(BuildOutput(package.name, package.folder, build, text))
    error = error or _missing_packages(package.name, outcome.errors)
    rest = escape(f"all of its output: {shown(log_of(failure.log))}")
    end = f"package '{package.name}' was not built; {rest}"
    if is_disk_full and (error is None or error.where is None):
        return end
    if error is None:
        lines = [f"    {escape(line)}" for line in text.strip().splitlines()[-_LINES:]]
        return "\n".join([f"error: package '{package.name}' was not built", *lines, rest])
    return f"{error.render()}\n{end}"


def _missing_packages(package: str, errors: str) -> LauncherError | None:
    """The error for a package that needs others, which options of colcon have left out."""
    found = re.findall(r"Check that the following packages have been built:((?:\n- .+)+)", errors)
    names = {name for lines in found for name in lines.strip().removeprefix("- ").split("\n- ")}
    if not names:
        return None
    others = ", ".join(f"'{name}'" for name in sorted(names))
    return LauncherError(
        f"'{package}' needs {others}, which {'is' if len(names) == 1 else 'are'} not built",
        hint=f"build what it needs too: {program()} build -- --packages-up-to {package}",
    )


def summary(outcome: BuildOutcome) -> str:
    """`3 built, 1 unchanged, 1 failed (a), 1 not tried (b)`."""
    parts = [f"{len(outcome.built)} built", f"{len(outcome.unchanged)} unchanged"]
    if outcome.failed:
        names = ", ".join(one.package.name for one in outcome.failed)
        parts.append(f"{len(outcome.failed)} failed ({names})")
    if outcome.not_tried:
        parts.append(f"{len(outcome.not_tried)} not tried ({', '.join(outcome.not_tried)})")
    if outcome.refused:
        parts.append(f"{len(outcome.refused)} refused ({', '.join(outcome.refused)})")
    total = len(outcome.built) + len(outcome.unchanged) + len(outcome.failed)
    total += len(outcome.not_tried) + len(outcome.refused)
    return f"{count(total, 'package')}: {', '.join(parts)}"


_LOG = "stdout_stderr.log"
_COLCON_LOG = "logger_all.log"
_MAX = 4 * 1024 * 1024  # bytes of a log; the first errors are the causes
_TIMEOUT_S = 60


def log_of(folder: str) -> str:
    """The log file with all output of a package, in colcon's folder for it.

    That of colcon itself if no tool was started for the package.
    """
    path = os.path.join(folder, _LOG)
    return path if os.path.exists(path) else os.path.join(os.path.dirname(folder), _COLCON_LOG)


def output_of(folder: str, log: str, stderr: str) -> str:
    """The output of the failed build of the package in `folder`.

    colcon runs setup.py for the metadata of a package, and drops what it writes.
    """
    text = _read(os.path.join(log, _LOG)) or stderr
    if "_get_setup_information" in text and "CalledProcessError" in text:
        return _of_setup(folder) or text
    return text


def _read(path: str) -> str:
    try:
        with open(path, "rb") as file:
            return file.read(_MAX).decode(errors="replace")
    except OSError:
        return ""


def _of_setup(folder: str) -> str:
    """What setup.py writes when it fails."""
    try:
        result = subprocess.run(
            [sys.executable, "setup.py", "--name"],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=_TIMEOUT_S,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return result.stdout.decode(errors="replace") if result.returncode else ""
