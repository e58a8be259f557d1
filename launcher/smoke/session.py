"""Session: a smoke command from its options to the exit code: runs, evidence, reports."""

from __future__ import annotations

import contextlib
import faulthandler
import json
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from launcher.errors import ExitCode
from launcher.smoke.narrator import Narrator
from launcher.smoke.reports import document, github, junit, measures, screen
from launcher.smoke.result import Judged, Result, worst
from launcher.smoke.runner import Runner
from launcher.smoke.script import Script
from launcher.smoke.system import STOP_S

# Import of rclpy, stop, leftovers, drawing: what a run may take beside the time that it watches.
HARD_ROOM_S = 4 * STOP_S
_COPIED = ("events.jsonl", "plan.json", "launch.log")
_MADE = ("graph.json", "graph.svg", "report.json", "expectations.yaml", *_COPIED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What is wanted of a smoke command beside its script. `words` are the launcher's."""

    words: tuple[str, ...]
    target: str
    junit: Path | None = None
    artifacts: Path | None = None
    github: bool = False
    repeat: int = 1
    baseline: Path | None = None
    update_baseline: bool = False


class Session:
    """Runs a script as often as wanted, tells about it, and keeps the evidence."""

    def __init__(self, script: Script, options: Options, *, colour: bool) -> None:
        self._script = script
        self._options = options
        self._colour = colour
        self._console = screen.console_for(sys.stdout, colour=colour)

    def run(self) -> ExitCode:
        """All runs; the exit code of the worst."""
        with _folder(self._options.artifacts) as keep, _terminable():
            results = self._runs(keep.path)
            regressions = self._compare(results)
            self._report(results, regressions)
            codes = [result.exit_code for result in results]
            if any(not one.is_met for one in regressions):
                codes.append(ExitCode.NOT_MET)
            code = worst(codes)
            keep.on_failure = code is not ExitCode.OK
        return code

    def _runs(self, folder: Path) -> list[Result]:
        results: list[Result] = []
        for number in range(1, self._options.repeat + 1):
            several = self._options.repeat > 1
            if several:
                print(f"--- run {number} of {self._options.repeat}", flush=True)
            results.append(self._run(folder / f"run-{number}" if several else folder))
            if results[-1].interrupted or results[-1].exit_code == ExitCode.USAGE:
                break
        return results

    def _run(self, folder: Path) -> Result:
        folder.mkdir(parents=True, exist_ok=True)
        for name in _MADE:
            (folder / name).unlink(missing_ok=True)  # of a run before
        narrator = Narrator(folder, sys.stdout, colour=self._colour)
        limit_s = self._script.run_time_s() + self._script.ready_limit_s() + HARD_ROOM_S
        # The last resort: whatever hangs in here, the command ends, and the launcher by itself.
        faulthandler.dump_traceback_later(limit_s, exit=True)
        try:
            runner = Runner(
                self._script,
                self._options.words,
                folder,
                narrator,
                keeps_graph=self._options.artifacts is not None,
            )
            result = runner.run()
        finally:
            faulthandler.cancel_dump_traceback_later()
            narrator.close()
        self._keep(result)
        if result.exit_code == ExitCode.USAGE:
            # Nothing was there to be judged; what is wrong is what the launcher says.
            print((folder / "launcher.out").read_text("utf-8", "replace"), end="", file=sys.stderr)
        else:
            screen.show(self._console, result)
        return result

    def _keep(self, result: Result) -> None:
        """The evidence beside the logs."""
        folder = result.folder
        text = json.dumps(document.of_result(result), indent=2, ensure_ascii=False)
        (folder / "report.json").write_text(text + "\n", encoding="utf-8")
        if self._script.path is not None:
            shutil.copyfile(self._script.path, folder / "expectations.yaml")
        for name in _COPIED:
            found = sorted((folder / "log").glob(f"*-*/{name}"))
            if found:
                shutil.copyfile(found[-1], folder / name)

    # ---- over all runs

    def _compare(self, results: Sequence[Result]) -> list[Judged]:
        """With the baseline; a file that is not there is written."""
        path = self._options.baseline
        if path is None or any(result.interrupted for result in results):
            return []
        found = measures.medians([measures.of_result(result) for result in results])
        if path.exists() and not self._options.update_baseline:
            return measures.compare(path, found)
        if any(result.exit_code for result in results):
            print(f"smoke: no baseline is written to {path}: not everything was met")
            return []
        measures.write(path, found)
        print(f"smoke: wrote {len(found)} measures to {path}")
        return []

    def _report(self, results: Sequence[Result], regressions: Sequence[Judged]) -> None:
        results = [*results[:-1], _with(results[-1], regressions)]
        if len(results) > 1:
            screen.show_flakes(self._console, results)
        for one in regressions:
            word = "held" if one.is_met else "WORSE"
            name = one.expectation.name
            print(f"{word}  {name}: {one.verdict.seen}, expected {one.verdict.expected}")
        if self._options.junit is not None:
            junit.write(self._options.junit, results, self._options.target)
        if self._options.github:
            for result in results:
                print("\n".join(github.commands(result)))


def _with(result: Result, more: Sequence[Judged]) -> Result:
    from dataclasses import replace

    return replace(result, judged=(*result.judged, *more))


class _Keep:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.on_failure = True


@contextlib.contextmanager
def _folder(wanted: Path | None) -> Iterator[_Keep]:
    """The folder for the evidence; one that nobody asked for goes if everything was well."""
    if wanted is not None:
        yield _Keep(wanted)
        return
    keep = _Keep(Path(tempfile.mkdtemp(prefix="smoke-")))
    try:
        yield keep
    finally:
        if keep.on_failure:
            print(f"smoke: the evidence is in {keep.path}")
        else:
            shutil.rmtree(keep.path, ignore_errors=True)


@contextlib.contextmanager
def _terminable() -> Iterator[None]:
    """SIGTERM and SIGHUP stop the system, as Ctrl-C does."""

    def interrupt(signum: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    signums = (signal.SIGTERM, signal.SIGHUP)
    before = {signum: signal.signal(signum, interrupt) for signum in signums}
    try:
        yield
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)
