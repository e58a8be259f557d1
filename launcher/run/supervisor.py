"""Runs one launch file, from the first process to the last."""

from __future__ import annotations

import contextlib
import functools
import gc
import signal

from launcher.base.errors import ExitCode
from launcher.posix import dispositions
from launcher.posix.spawn import set_close_on_exec
from launcher.run.part import When

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from launcher.base.model.events import Event
    from launcher.run.run import Run

PRUNE_S, PRUNE_LEAST = 0.01, 20  # at the end of a run: so long, and at least so many steps
KEPT = "The last 20 runs stay there, and all that failed or have a snapshot"


class Supervisor:
    """Begins a run, keeps it going, and ends it."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._pruning = self._old_runs()
        run.screen.on_closed = lambda: run.shutdown.output_closed()

    def run(self) -> ExitCode:
        """Run to the end, and return the exit code. No process is left even after an exception."""
        with self.running():
            self._run.reactor.run()
        return self._exit_code()

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """The run; within, the reactor must run until it is stopped."""
        run = self._run
        with contextlib.suppress(ValueError):  # a script runs it in another thread
            dispositions.notice_children()
        run.reactor.on_signals(dispositions.ENDING, lambda signum: run.shutdown.interrupt(signum))
        set_close_on_exec()
        run.reactor.on_signals((signal.SIGWINCH,), self._terminal_resized)
        is_orderly = False
        try:
            if run.log_dir is not None:
                run.log.log("INFO", "launch", f"All log files can be found below {run.log_dir}")
                run.log.log("INFO", "launch", KEPT)
            if any(part.open(self._begin) for part in run.parts):
                run.idle()
            else:
                self._begin()
            yield
            is_orderly = True
        finally:
            try:
                self._clean_up(is_orderly=is_orderly)
            finally:
                for part in reversed([*run.parts]):
                    part.close()

    @property
    def stop_signal(self) -> int | None:
        """The first signal that ended the run."""
        return self._run.shutdown.machine.stop_signal

    def feed(self, event: Event) -> None:
        """Pass an event to the core from outside, in the thread of the reactor."""
        self._run.core_driver.feed(event)
        self._run.shutdown.idle()

    def stay_while(self, condition: Callable[[], bool]) -> None:
        """Do not end for want of processes while this is true."""
        self._run.core_driver.stays = condition

    def _exit_code(self) -> ExitCode:
        run = self._run
        return ExitCode.PROCESS_FAILED if run.core.has_failed else run.shutdown.exit_code()

    def _begin(self) -> None:
        run = self._run
        when_idle = run.reactor.when_idle
        when_idle(run.idle)  # first: it imports what the exit of a process needs
        when_idle(functools.partial(__import__, "json"))  # for the events
        with run.screen.collecting(), run.directory.collecting():
            run.core_driver.start()
            run.is_begun = True
            for part in run.parts:
                part.settled()
        run.parts.begin(When.BEGUN)
        for what in (run.driver.watch_memory, _settle, self._prune):
            when_idle(what)

    def _terminal_resized(self, signum: int) -> None:
        from launcher.posix.pseudo_terminals import size_beside

        for process in self._run.all_processes.values():
            if process.child is not None:
                process.child.resize(size_beside(len(process.name) + 3))

    # ---- folders of old runs

    def _old_runs(self) -> Iterator[None]:
        """Delete old runs, one in each step."""
        from launcher.output.logs.old_runs import prune

        if self._run.log_dir is not None:
            yield from prune(self._run.log_dir)

    def _prune(self) -> None:
        if next(self._pruning, "over") is None:
            self._run.reactor.when_idle(self._prune)

    def _prune_rest(self) -> None:
        """A run of some milliseconds has no idle moment: go on for a little while."""
        until_s = self._run.reactor.now() + PRUNE_S
        for step, _ in enumerate(self._pruning, 1):
            # However slow the machine is, such runs must not leave more than they delete.
            if step >= PRUNE_LEAST and self._run.reactor.now() >= until_s:
                break

    # ---- the end

    def _clean_up(self, *, is_orderly: bool) -> None:
        from launcher.run.monitor.housekeeping import Housekeeping

        run = self._run
        for process in run.all_processes.values():
            if process.child is not None:
                # Only after an exception: an orderly end has reaped every child.
                process.child.signal_group(signal.SIGKILL)
            run.driver.release(process)
        run.shutdown.end_helpers()
        run.parts.need(Housekeeping)  # a short run may have none yet
        for part in run.parts:
            part.conclude(is_orderly=is_orderly)
        run.watchdog.close()
        if is_orderly:
            self._summarize()  # as the last lines
        deaths = sum(process.history.deaths for process in run.all_processes.values())
        from launcher.base.model.run_events import Finished

        run.log.note(Finished(int(self._exit_code()), deaths))
        self._finish_output()
        if is_orderly:
            self._prune_rest()

    def _summarize(self) -> None:
        from launcher.run.logs import summary

        run = self._run
        summary.conclude(
            run.log,
            run.screen,
            list(run.all_processes.values()),
            run.shutdown,
            code=self._exit_code(),
            has_exception=run.core.has_failed,
            is_script=run.launched.is_script,
            is_test=run.launched.is_test,
        )

    def _finish_output(self) -> None:
        screen, directory = self._run.screen, self._run.directory
        lost_lines = screen.finish()
        if lost_lines:
            text = f"{lost_lines} lines were not shown: nobody read the output any more"
            directory.log("WARNING", "launch", text)
        if screen.dropped_bytes:
            text = f"dropped {screen.dropped_bytes} bytes of output: the disk was full"
            directory.log("WARNING", "launch", text)
        directory.close()


def _settle() -> None:
    """Exclude what exists now from garbage collection: a full one would take milliseconds."""
    gc.freeze()
    gc.enable()
