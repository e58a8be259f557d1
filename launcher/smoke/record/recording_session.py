"""`smoke --record FILE`: watch healthy runs, and write the expectations that they meet."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.text import count
from launcher.smoke.preflight.forecast import Forecast
from launcher.smoke.record.document import Document, Head, document_of
from launcher.smoke.record.observed_run import ObservedRun
from launcher.smoke.record.recorded_runs import Runs
from launcher.smoke.record.watched_run import RecordedRunner, script_of
from launcher.smoke.reports import artifacts, text_report
from launcher.smoke.reports.result import SmokeResult
from launcher.smoke.run.runner import code_of, terminable
from launcher.smoke.run.smoke_session import HARD_ROOM_S, ReportingSession

FOR_S = 15.0  # so that a topic with a message in two seconds has a rate
READY_WITHIN_S = 60.0
RUNS = 2  # what differs between them differs in other runs, too


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingOptions:
    """Options of a recording. `words` are for the launcher; `is_forced`: replace the file."""

    path: Path
    words: tuple[str, ...]
    head: Head
    ready_within_s: float = READY_WITHIN_S
    repeat: int = RUNS
    artifacts: Path | None = None
    is_forced: bool = False

    def refuse_unwritable(self) -> None:
        """LauncherError if the file could not be written, or would replace another one."""
        if self.head.for_s <= 0:
            raise UsageError("nothing can be observed in 0 s", hint="increase --for")
        if os.path.lexists(self.path) and not self.is_forced:
            raise _exists(self.path)
        artifacts.refuse_unwritable(
            artifacts=self.artifacts,
            junit=None,
            baseline=None,
            record=self.path,
            repeat=self.repeat,
        )


def _exists(path: Path) -> LauncherError:
    return UsageError(f"--record {path}: the file exists", hint="--force replaces it")


class RecordSession(ReportingSession):
    def __init__(self, recording: RecordingOptions, *, colour: bool) -> None:
        super().__init__(colour=colour)
        self._recording = recording
        self._forecast: Forecast | None = None

    def run(self) -> ExitCode:
        """The exit code; the file is written only if all runs were healthy."""
        with (
            contextlib.redirect_stdout(self._stdout),
            artifacts.evidence(self._recording.artifacts) as folder,
            terminable(),
        ):
            try:
                code = self._record(folder.path)
            except KeyboardInterrupt as interrupt:
                code = code_of(interrupt)
            folder.is_kept = code is not ExitCode.OK
        return code

    def _record(self, folder: Path) -> ExitCode:
        recording = self._recording
        seen: list[ObservedRun] = []
        for number, path in enumerate(artifacts.runs_in(folder, recording.repeat), 1):
            print(f"--- run {number} of {recording.repeat}", flush=True)
            result, one = self._watch(path)
            if result.exit_code:
                return self._refuse(result, number)
            seen.append(one)
        document = document_of(Runs(seen), recording.head, self._forecast)
        try:
            write(recording.path, document.text, is_forced=recording.is_forced)
        except OSError as error:
            return _unwritten(recording.path, error)
        print(f"smoke: wrote {_summary(document)} to {recording.path}")
        return ExitCode.OK

    def _watch(self, folder: Path) -> tuple[SmokeResult, ObservedRun]:
        recording, for_s = self._recording, self._recording.head.for_s
        limit_s = 2 * for_s + recording.ready_within_s + HARD_ROOM_S
        with self._progress(folder, limit_s) as progress:
            script = script_of(for_s, recording.ready_within_s)
            watch = RecordedRunner(script, recording.words, folder, progress)
            result = watch.run()
        self._forecast = self._forecast or watch.forecast
        return result, ObservedRun(result.facts, for_s, watch.states)

    def _refuse(self, result: SmokeResult, number: int) -> ExitCode:
        path = self._recording.path
        if result.exit_code is ExitCode.USAGE:
            print("\n".join(result.last_lines), file=sys.stderr)
            return result.exit_code
        if result.interrupted is None:
            text_report.show(self._console, result)
        reason = "interrupted" if result.interrupted else f"run {number} was not healthy"
        sys.stdout.flush()
        print(f"error: nothing was recorded in {path}: {reason}", file=sys.stderr)
        return result.exit_code


def _summary(document: Document) -> str:
    left = f" ({document.left_out} left out, with the reasons)" if document.left_out else ""
    return f"{count(document.expected, 'expectation')}{left}"


def _unwritten(path: Path, error: OSError) -> ExitCode:
    if isinstance(error, FileExistsError):
        reason = _exists(path)
        print(f"error: {reason.message}\nhint: {reason.hint}", file=sys.stderr)
    else:
        print(f"error: cannot write {path}: {error.strerror}", file=sys.stderr)
    return ExitCode.PROCESS_FAILED


def write(path: Path, text: str, *, is_forced: bool) -> None:
    """Write the whole file at once, and make its folder; OSError, FileExistsError unless forced.

    A symbolic link is followed, so that it stays one.
    """
    path = Path(os.path.realpath(path)) if is_forced else path
    path.parent.mkdir(parents=True, exist_ok=True)
    with _temporary(path) as fresh:
        fresh.write_text(text, encoding="utf-8")
        if is_forced:
            _take_mode(path, fresh)
            os.replace(fresh, path)
        else:
            _link(fresh, path)


def _link(fresh: Path, path: Path) -> None:
    """A rename would replace a file that has come into being meanwhile."""
    try:
        os.link(fresh, path)
    except OSError as error:
        if error.errno not in (errno.EPERM, errno.ENOTSUP, errno.EMLINK):
            raise
        if os.path.lexists(path):  # a file system without hard links
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path)) from None
        os.replace(fresh, path)


def _take_mode(path: Path, fresh: Path) -> None:
    with contextlib.suppress(FileNotFoundError):
        fresh.chmod(path.stat().st_mode & 0o777)


@contextlib.contextmanager
def _temporary(path: Path) -> Iterator[Path]:
    """A new file beside the path, with the permissions of any new file; it is removed."""
    with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as folder:
        yield Path(folder, path.name)
