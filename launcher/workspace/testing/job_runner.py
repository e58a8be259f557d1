"""Runs jobs, several at a time, each in a separate ROS domain, and leaves no process behind."""

from __future__ import annotations

import contextlib
import os
import secrets
import signal
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from launcher.base.errors import LauncherError
from launcher.posix import dispositions, spawn
from launcher.posix.cleanup import subreaper, sweep
from launcher.posix.cleanup.watchdog_client import WatchdogClient
from launcher.posix.domain_lease import leased_domain
from launcher.posix.reactor import Reactor, Timer
from launcher.run.monitor import shared_memory
from launcher.workspace.testing.package_jobs import Job, environment, remove_results

# pytest ends its fixtures on SIGINT, and systems that they have launched need time; SIGABRT has it
# print where it hangs.
_STEPS = ((signal.SIGINT, 15.0), (signal.SIGABRT, 2.0), (signal.SIGKILL, 2.0))
_SETTLE_S = 3.0  # for processes that are about to end
_STOP_S = 3.0  # between SIGTERM and SIGKILL of those that are left
_LOOK_S = 0.1
_DEATH_S = 0.01  # one with much memory dies late
TICK_S = 0.5


@dataclass
class JobOutcome:
    """How a job ended; `returncode` is negative for a signal, None if it was not started."""

    job: Job
    returncode: int | None = None
    elapsed_s: float = 0.0
    timeout_s: float | None = None  # that it has exceeded
    is_interrupted: bool = False  # by a signal to the launcher
    problem: str = ""  # why it could not be started
    left: list[str] = field(default_factory=list)  # processes that it left behind

    @property
    def is_timeout(self) -> bool:
        return self.timeout_s is not None

    @property
    def ending(self) -> str:
        """Why there are no results of some tests; empty if the tests ended by themselves."""
        if self.problem:
            return "not started"
        if self.is_timeout:
            return "timed out"
        if self.is_interrupted:
            return "interrupted"
        return "killed" if self.returncode is not None and self.returncode < 0 else ""


class RunnerListener:
    """Receives what a Runner does; every method may be left out."""

    def started(self, job: Job) -> None: ...

    def finished(self, outcome: JobOutcome) -> None: ...

    def tick(self, running: Mapping[str, float]) -> None:
        """Several times a second; package -> seconds since its start."""

    def warn(self, text: str) -> None: ...


class JobRunner:
    """`workers` jobs at a time; each may take `timeout_s`.

    With `in_foreground` jobs have the launcher's own terminal or files, else their output goes to
    their log.
    """

    def __init__(
        self,
        jobs: Sequence[Job],
        environ: Mapping[str, str],
        listener: RunnerListener,
        *,
        workers: int,
        timeout_s: float | None = None,
        in_foreground: bool = False,
    ) -> None:
        self._waiting = list(jobs)
        self._environ = environ
        self._listener = listener
        self._workers = workers
        self.timeout_s = timeout_s
        self.in_foreground = in_foreground
        self._running: dict[str, _JobRun] = {}
        self.outcomes: list[JobOutcome] = []
        self.signum: int | None = None  # that has ended it

    def run(self) -> list[JobOutcome]:
        """Run all; the outcomes in the order of their ends."""
        with Reactor() as self.reactor:
            self.reactor.on_signals(dispositions.ENDING, self._interrupt)
            watchdog = WatchdogClient(self.reactor, _run_id(), self._listener.warn)
            watchdog.ensure()
            try:
                self._start_more()
                self._tick()
                self.reactor.run()
                _kill_orphans()
            finally:
                watchdog.close()
        return self.outcomes

    def _start_more(self) -> None:
        while self._waiting and len(self._running) < self._workers and self.signum is None:
            job = self._waiting.pop(0)
            run = _JobRun(self, job, self._environ)
            self._running[job.package] = run
            self._listener.started(job)
            run.start()
        if not self._running:
            self.reactor.stop()

    def ended(self, outcome: JobOutcome) -> None:
        outcome.is_interrupted = self.signum is not None
        del self._running[outcome.job.package]
        self.outcomes.append(outcome)
        self._listener.finished(outcome)
        self._start_more()

    def _interrupt(self, signum: int) -> None:
        if self.signum is None:
            self.signum = signum
            self.outcomes += [JobOutcome(job, is_interrupted=True) for job in self._waiting]
            self._waiting.clear()
        for run in [*self._running.values()]:  # the second signal shortens the wait
            run.stop()

    def _tick(self) -> None:
        now = self.reactor.now()
        self._listener.tick({name: now - run.began for name, run in self._running.items()})
        self.reactor.call_later(TICK_S, self._tick)


class _JobRun:
    """One job, from its lease of a domain to the end of the last process that it has started."""

    def __init__(self, runner: JobRunner, job: Job, environ: Mapping[str, str]) -> None:
        self._runner = runner
        self._reactor = runner.reactor
        self._environ = environ
        self._outcome = JobOutcome(job)
        self._run_id = _run_id()
        self._stack = contextlib.ExitStack()
        self._pid = self._pidfd = -1
        self._step = 0
        self._timer: Timer | None = None
        self.began = self._reactor.now()

    def start(self) -> None:
        job = self._outcome.job
        try:
            remove_results(job)
            domain_id = self._stack.enter_context(leased_domain())
            env = environment(self._environ, domain_id, self._run_id)
            streams = self._streams(job)
            self._pid = spawn.execute(job.command, env=env, streams=streams, cwd=job.folder)
            self._pidfd = os.pidfd_open(self._pid)
        except (OSError, LauncherError) as error:
            self._outcome.problem = _reason(error)
            self._reactor.call_later(0, self._end)
            return
        self._reactor.add_reader(self._pidfd, self._exited)
        if self._runner.timeout_s is not None:
            self._timer = self._reactor.call_later(self._runner.timeout_s, self._time_out)

    def _streams(self, job: Job) -> tuple[int, int, int]:
        """Those of the process, closed at the end of the run; OSError."""
        if self._runner.in_foreground:
            stdin, stdout, stderr = (os.dup(number) for number in range(3))
        else:
            stdin = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
            flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC
            stdout = os.open(job.log, flags, 0o666)
            stderr = os.dup(stdout)
        for fd in (stdin, stdout, stderr):
            self._stack.callback(os.close, fd)
        return stdin, stdout, stderr

    # ---- its end

    def stop(self) -> None:
        """Take the next step towards its end."""
        if self._pidfd < 0:
            return  # only processes that it has left are still there
        if self._timer is not None:
            self._timer.cancel()
        signum, wait_s = _STEPS[min(self._step, len(_STEPS) - 1)]
        self._step += 1
        with contextlib.suppress(ProcessLookupError):
            # Only the process itself prints where it is; a core dump of each child helps nobody.
            os.kill(self._pid, signum) if signum == signal.SIGABRT else os.killpg(self._pid, signum)
        self._timer = self._reactor.call_later(wait_s, self.stop)

    def _time_out(self) -> None:
        self._outcome.timeout_s = self._runner.timeout_s
        self.stop()

    def _exited(self) -> None:
        self._reactor.remove(self._pidfd)
        self._outcome.returncode, _ = spawn.reap(self._pidfd)
        os.close(self._pidfd)
        self._pidfd = -1
        self._outcome.elapsed_s = self._reactor.now() - self.began
        if self._timer is not None:
            self._timer.cancel()
        self._look_for_left(self._reactor.now() + _SETTLE_S)

    def _look_for_left(self, deadline: float) -> None:
        found, in_exec = sweep.find(self._run_id)
        if not found and not in_exec:
            self._end()
        elif self._reactor.now() < deadline:
            self._reactor.call_later(_LOOK_S, partial(self._look_for_left, deadline))
        else:
            self._outcome.left = [_described(pid) for pid in found]
            self._sweep(signal.SIGTERM, self._reactor.now() + _STOP_S)

    def _sweep(self, signum: int, deadline: float) -> None:
        if not sweep.signal_all(self._run_id, signum):
            self._end()
            return
        if self._reactor.now() > deadline:
            signum = signal.SIGKILL
        again = partial(self._sweep, 0 if signum == signal.SIGTERM else signum, deadline)
        self._reactor.call_later(_LOOK_S, again)

    def _end(self) -> None:
        outcome = self._outcome
        if outcome.left or (outcome.returncode or 0) < 0:
            shared_memory.free(item.name for item in shared_memory.stale())
        self._stack.close()
        self._runner.ended(outcome)


def _run_id() -> str:
    """As that of a launch: `doctor` finds processes whose launcher is gone by it."""
    return f"{os.getpid()}-{secrets.token_hex(4)}"


def _reason(error: Exception) -> str:
    if isinstance(error, OSError):
        return ": ".join(filter(None, (error.filename, error.strerror)))
    return str(error)


def _described(pid: int) -> str:
    from launcher.posix import proc

    words = proc.details(pid, "cmdline").get("cmdline") or ()
    return f"{' '.join(filter(None, words)) or '?'} [{pid}]"


def _kill_orphans() -> None:
    """Processes that have cleared their environment and left their session, until all are dead."""
    deadline_s = time.monotonic() + _STOP_S
    while (orphans := subreaper.orphans()) and time.monotonic() < deadline_s:
        for pid in orphans:
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(_DEATH_S)
