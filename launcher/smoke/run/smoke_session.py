"""A smoke command from its options to the exit code: runs, evidence, reports."""

from __future__ import annotations

import contextlib
import faulthandler
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, cast

from launcher.base import strict_json
from launcher.base.document.document_reader import together
from launcher.base.errors import ExitCode, LauncherError
from launcher.base.github import add_summary
from launcher.smoke.expect.script import Script
from launcher.smoke.observe import topic_recording
from launcher.smoke.preflight import forecast
from launcher.smoke.preflight.forecast import Forecast
from launcher.smoke.reports import artifacts, github, json_report, junit, measures, text_report
from launcher.smoke.reports.result import Judged, SmokeResult, worst
from launcher.smoke.run.runner import Runner, code_of, terminable
from launcher.smoke.run.smoke_progress import PipeSafeStdout, SmokeProgress
from launcher.smoke.run.system import STOP_S

# Importing rclpy, stopping, leftovers, drawing: what a run may take besides its duration.
HARD_ROOM_S = 4 * STOP_S
MAX_LIMIT_S = 1e8  # three years; faulthandler accepts no longer times


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Options of a smoke command besides its script.

    `words` are for the launcher. `plan_words` are those that name the launch file, its arguments,
    and how it is read.
    """

    words: tuple[str, ...]
    target: str
    plan_words: tuple[str, ...] = ()
    junit: Path | None = None
    html: Path | None = None
    artifacts: Path | None = None
    github: bool = False
    repeat: int = 1
    baseline: Path | None = None
    update_baseline: bool = False

    def refuse_unwritable(self) -> None:
        """LauncherError if a result could not be written, or the baseline not be read."""
        base = self.baseline
        is_read = base is not None and base.exists() and not self.update_baseline
        artifacts.refuse_unwritable(
            artifacts=self.artifacts,
            junit=self.junit,
            html=self.html,
            baseline=None if is_read else base,
            repeat=self.repeat,
        )
        if base is not None and is_read:
            measures.read(base)
        if self.html is not None:
            from launcher.smoke.reports import html_report

            html_report.check()


def _remove_recording(folder: Path) -> None:
    """It is evidence of what was not as expected."""
    for name in (topic_recording.FOLDER, topic_recording.SNAPSHOT):
        shutil.rmtree(folder / name, ignore_errors=True)


class ReportingSession:
    """Base of smoke commands: what they print, and the progress of each run."""

    def __init__(self, *, colour: bool) -> None:
        self._colour = colour
        self._stdout = PipeSafeStdout(sys.stdout)
        self._console = text_report.console_for(cast("IO[str]", self._stdout), colour=colour)

    @contextlib.contextmanager
    def _progress(self, folder: Path, limit_s: float) -> Iterator[SmokeProgress]:
        """The progress of a run that takes at most so long."""
        progress = SmokeProgress(folder, cast("IO[str]", self._stdout), colour=self._colour)
        # The last resort for a command that hangs; the launcher then stops by itself.
        faulthandler.dump_traceback_later(min(limit_s, MAX_LIMIT_S), exit=True)
        try:
            yield progress
        finally:
            faulthandler.cancel_dump_traceback_later()
            progress.close()


class Session(ReportingSession):
    def __init__(self, script: Script, options: Options, *, colour: bool) -> None:
        super().__init__(colour=colour)
        self._script = script
        self._options = options
        self._unwritten = False

    @property
    def _is_of_use(self) -> bool:
        """Whether it matters what the launch file starts."""
        return self._script.waits_beyond() or any(forecast.mentions(self._script))

    def _judge(self, foreseen: Forecast) -> None:
        """LauncherError for processes that the launch file does not start; prints warnings."""
        found = forecast.compare(self._script, foreseen)
        for warning in found.warnings:
            print(f"smoke: warning: {warning}", file=sys.stderr)
        if found.errors:
            raise together(found.errors)

    def run(self) -> ExitCode:
        """The exit code of the worst run; LauncherError before any if the script is wrong."""
        with (
            contextlib.redirect_stdout(self._stdout),
            artifacts.evidence(self._options.artifacts) as folder,
            terminable(),
        ):
            try:
                code = self._all(folder.path)
            except LauncherError:
                folder.is_kept = False  # nothing was run
                raise
            folder.is_kept = code is not ExitCode.OK
        return code

    def _all(self, folder: Path) -> ExitCode:
        results: list[SmokeResult] = []
        try:
            self._runs(folder, results)
        except LauncherError:
            for path in (*artifacts.runs_in(folder, self._options.repeat), folder):
                artifacts.discard(path)
            raise
        except KeyboardInterrupt as interrupt:
            print("smoke: interrupted")  # while a run was prepared or reported
            if not results:
                return code_of(interrupt)
        except OSError as error:
            if not results:
                raise
            self._unwritten = True
            print(f"smoke: no more runs: {error.strerror}: {error.filename}")
        regressions = self._compare(results)
        self._report(results, regressions)
        codes = [result.exit_code for result in results]
        if any(not one.is_met for one in regressions):
            codes.append(ExitCode.NOT_MET)
        if self._unwritten or self._stdout.trouble:
            codes.append(ExitCode.PROCESS_FAILED)
        code = worst(codes)
        if [code] != codes:
            print(f"smoke: exit code {int(code)}")  # each run has printed its own
        return code

    def _runs(self, folder: Path, results: list[SmokeResult]) -> None:
        folders = [*artifacts.runs_in(folder, self._options.repeat)]
        for number, path in enumerate(folders, 1):
            if len(folders) > 1:
                print(f"--- run {number} of {len(folders)}", flush=True)
            results.append(self._run(path if len(folders) > 1 else folder))
            if results[-1].interrupted or results[-1].exit_code == ExitCode.USAGE:
                break

    def _run(self, folder: Path) -> SmokeResult:
        folder.mkdir(parents=True, exist_ok=True)
        for name in artifacts.MADE:
            (folder / name).unlink(missing_ok=True)  # of a run before
        _remove_recording(folder)
        limit_s = self._script.run_time_s() + self._script.ready_limit_s() + HARD_ROOM_S
        with self._progress(folder, limit_s) as progress:
            runner = Runner(
                self._script,
                self._options.words,
                folder,
                progress,
                keeps_graph=self._options.artifacts is not None,
                keeps_page=self._options.html is not None,
                judge=self._judge if self._is_of_use else None,
            )
            result = runner.run()
        if progress.trouble is not None:
            self._unwritten = True
        with self._writing(f"the evidence in {folder}"):
            self._keep(result)
        if result.exit_code == ExitCode.OK:
            _remove_recording(folder)
        if result.exit_code == ExitCode.USAGE:
            # There was nothing to judge; the launcher has printed the error.
            print("\n".join(result.last_lines), file=sys.stderr)
        else:
            text_report.show(self._console, result)
        return result

    def _keep(self, result: SmokeResult) -> None:
        folder = result.folder
        text = strict_json.dumps(json_report.of_result(result), indent=2, ensure_ascii=False)
        artifacts.save(folder / "report.json", f"{text}\n")
        if self._script.path is not None:
            shutil.copyfile(self._script.path, folder / "expectations.yaml")
        for name in artifacts.COPIED:
            found = sorted((folder / "log").glob(f"*-*/{name}"))
            if found:
                shutil.copyfile(found[-1], folder / name)

    # ---- over all runs

    def _compare(self, results: Sequence[SmokeResult]) -> list[Judged]:
        """Compare with the baseline; a missing one is written."""
        path = self._options.baseline
        if path is None or any(result.interrupted for result in results):
            return []
        found = measures.medians([measures.of_result(result) for result in results])
        if path.exists() and not self._options.update_baseline:
            return measures.compare(path, found)
        if any(result.exit_code for result in results):
            print(f"smoke: no baseline is written to {path}: the run failed")
            return []
        with self._writing(f"the baseline {path}"):
            measures.write(path, found)
            print(f"smoke: wrote {len(found)} measures to {path}")
        return []

    @contextlib.contextmanager
    def _writing(self, what: str) -> Iterator[None]:
        """An error of the disk fails the command, but the rest is still reported."""
        try:
            yield
        except OSError as error:
            self._unwritten = True
            print(f"smoke: cannot write {what}: {error.strerror}")

    def _report(self, results: Sequence[SmokeResult], regressions: Sequence[Judged]) -> None:
        last = replace(results[-1], judged=(*results[-1].judged, *regressions))
        results = [*results[:-1], last]
        if len(results) > 1:
            text_report.show_flakes(self._console, results)
        for one in regressions:
            word = "held" if one.is_met else "WORSE"
            name = one.expectation.name
            print(f"{word}  {name}: {one.verdict.seen}, expected {one.verdict.expected}")
        if self._options.junit is not None:
            with self._writing(f"--junit {self._options.junit}"):
                junit.write(self._options.junit, results, self._options.target)
        if self._options.html is not None:
            self._write_page(self._options.html, results)
        if self._options.github:
            for result in results:
                for command in github.commands(result):
                    print(command)
            problem = add_summary(os.environ, github.summary(results, self._options.target))
            if problem is not None:
                print(f"smoke: warning: {problem}", file=sys.stderr)

    def _write_page(self, path: Path, results: Sequence[SmokeResult]) -> None:
        from launcher.smoke.reports import html_report

        with self._writing(f"--html {path}"):
            html_report.write(path, results, self._options.target, self._options.plan_words)
