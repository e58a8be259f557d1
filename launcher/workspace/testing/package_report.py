"""What `test` prints: a line per package, the output of those that failed, and a summary."""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Mapping, Sequence

from launcher.base.errors import ExitCode
from launcher.base.model.events import signal_name
from launcher.base.program import program
from launcher.base.text import drop_controls, escape
from launcher.workspace.building.sources.source_text import shown
from launcher.workspace.building.status_line import BuildStatusLine
from launcher.workspace.testing import package_results
from launcher.workspace.testing.job_runner import JobOutcome, RunnerListener
from launcher.workspace.testing.package_jobs import NO_TESTS_COLLECTED, Job
from launcher.workspace.testing.package_results import FailedTest, Results

_LAST_LINES = 300  # of the output of a package that failed
_TAIL_BYTES = 256 * 1024
_LINTER = re.compile(r"No module named '(ament_\w+)")


class Report(RunnerListener):
    """Prints as it goes. With `in_foreground` the tests write to the terminal themselves."""

    def __init__(self, total: int, *, in_foreground: bool, verbose: bool) -> None:
        self._total = total
        self._in_foreground = in_foreground
        self._verbose = verbose
        self._line = BuildStatusLine(sys.stdout)
        self.judged: dict[str, tuple[Results, str]] = {}  # package -> results, what went wrong
        self._incomplete: dict[str, list[str]] = {}  # `timed out`, `not built`, ... -> packages

    # ---- while they run

    def tick(self, running: Mapping[str, float]) -> None:
        if running and not self._in_foreground:
            parts = ", ".join(f"{name} {seconds:.0f} s" for name, seconds in running.items())
            self._line.write(f"[{len(self.judged)}/{self._total}] {parts}")

    def finished(self, outcome: JobOutcome) -> None:
        self._line.clear()
        was_ended = outcome.is_timeout or outcome.is_interrupted
        found = package_results.read(outcome.job, is_complete=not was_ended)
        problem = problem_of(outcome, found)
        self.judged[outcome.job.package] = (found, problem)
        if outcome.ending:
            self._incomplete.setdefault(outcome.ending, []).append(outcome.job.package)
        if not self._in_foreground and (self._verbose or problem):
            _print_output(outcome.job)
        for process in outcome.left:
            name = outcome.job.package
            self.warn(escape(f"{name} left a process behind, which was stopped: {process}"))
        if not self._in_foreground:
            print(_row(outcome, found, problem), flush=True)

    def warn(self, text: str) -> None:
        self._line.clear()
        print(f"warning: {text}", file=sys.stderr)

    # ---- at the end

    def summarize(self, outcomes: Sequence[JobOutcome], not_built: Sequence[str]) -> ExitCode:
        """Print it; the exit code without regard to signals."""
        for outcome in outcomes:
            if outcome.job.package not in self.judged:
                self._leave_out(outcome.job.package, "not run")
        for name in not_built:
            self._leave_out(name, "not built")
        failures = [one for found, _ in self.judged.values() for one in found.failures]
        print()
        for failure in failures:
            print(f"failed: {escape(str(failure))}")
        for name, (_, problem) in self.judged.items():
            if problem:
                print(f"{name}: {escape(problem)}")
        for hint in sorted({*filter(None, map(_hint, failures))}):
            print(f"hint: {hint}")
        print(self.total())
        has_passed = any(found.passed for found, _ in self.judged.values())
        has_problem = any(problem for _, problem in self.judged.values())
        if not has_passed and not has_problem:
            print("no test ran", file=sys.stderr)
        return ExitCode.OK if has_passed and not has_problem else ExitCode.PROCESS_FAILED

    def total(self) -> str:
        """The counts of all packages, in a line."""
        return package_results.total([found for found, _ in self.judged.values()], self._incomplete)

    def _leave_out(self, package: str, why: str) -> None:
        self.judged[package] = (Results(), why)
        self._incomplete.setdefault(why, []).append(package)


def problem_of(outcome: JobOutcome, found: Results) -> str:
    """Why the package did not pass; empty if it did, or has no tests."""
    code = outcome.returncode
    if outcome.problem:
        return f"could not be started: {outcome.problem}"
    if outcome.is_timeout:
        where = package_results.place_of_end(outcome.job)
        return f"timed out after {outcome.timeout_s:g} s{where and f', at {where}'}"
    if outcome.is_interrupted:
        return "interrupted"
    if code is not None and code < 0:
        return f"killed by {signal_name(-code)}"
    if found.failed:
        return f"{found.failed} failed"
    if found.problem:
        return found.problem
    if code == NO_TESTS_COLLECTED and not outcome.job.is_ctest:
        return ""
    tool = "ctest" if outcome.job.is_ctest else "pytest"
    return f"{tool} ended with {code}" if code else ""


def _hint(failure: FailedTest) -> str | None:
    """About the tests of style that `ros2 pkg create` puts into a package."""
    missing = _LINTER.search(failure.message)
    if missing is None:
        return None
    return (
        f"{missing[1]} is not installed; without the tests that need it: "
        f"{program()} test -- --ignore-glob='*/test_{missing[1].removeprefix('ament_')}.py'"
    )


def _row(outcome: JobOutcome, found: Results, problem: str) -> str:
    has_counts = found.passed or found.failed or found.skipped
    parts = [str(found) if has_counts or not problem else "", "" if found.failed else problem]
    return escape(
        f"{outcome.job.package}: {': '.join(filter(None, parts))} ({outcome.elapsed_s:.1f} s)"
    )


def _print_output(job: Job) -> None:
    """The end of the log, as a separate block."""
    with contextlib.suppress(OSError), open(job.log, "rb") as file:
        file.seek(max(0, os.fstat(file.fileno()).st_size - _TAIL_BYTES))
        lines = file.read().decode(errors="replace").removesuffix("\n").split("\n")
        if len(lines) > _LAST_LINES or file.tell() > _TAIL_BYTES:
            lines = [f"... all of it: {shown(job.log)}", *lines[-_LAST_LINES:]]
        print(f"--- {job.package}")
        print(drop_controls("\n".join(lines)))
