"""Starts Python nodes warm: by forks of a preparing process that has imported what they need.

A start is asynchronous: its process is STARTING until it reports that its program begins. The
preparing process makes one after the other, so that few descriptors are open at a time. Whatever
goes wrong, the process is started cold.
"""

from __future__ import annotations

import contextlib
import functools
import os
import signal
from collections import deque

from launcher.base.model.spec import RestartMode
from launcher.posix import spawn
from launcher.posix.cleanup import subreaper
from launcher.run.warm.eligibility import Prepared, folder_of, judge, obstacle
from launcher.run.warm.preparing_process import PreparingProcess
from launcher.run.warm.request import WarmStart

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from launcher.base.model.spec import ProcessSpec
    from launcher.posix.reactor import Reactor, Timer
    from launcher.run.processes.process import Process
    from launcher.run.processes.process_driver import ProcessDriver


MOST_SENT = 2  # the preparing process always has the next one at hand
SETTLED_S = 3.0  # after a start, imports no longer compete with it
MANY_LATE = 2  # for each processor: more later starts than that are followed by others
MOST_BASES = 4  # environments that are tried
MOST_FAILURES = 3  # then the run goes on without preparing


class WarmSpawner:
    """Decides on each start, and carries out the warm ones.

    `is_forced`: by `--warm`, a start always waits for the preparation. Else it waits if that makes
    it sooner: if more nodes are to be started than there are processors. Otherwise the first ones
    are started cold. What the next starts need is prepared at once if these are many: the processes
    that are `held` back, or after many starts that came later. Else it is prepared when the first
    ones have settled, if a next start is to be expected: they have a restart policy, or a user or
    an edited file may restart them (`is_interactive`). Call `settle` when the static part of the
    launch file has been carried out.
    """

    def __init__(
        self,
        reactor: Reactor,
        driver: ProcessDriver,
        *,
        settings_of: Callable[[Process, ProcessSpec], spawn.StartSettings],
        warn: Callable[[str], object],
        is_forced: bool,
        is_interactive: bool,
        held: Callable[[], Sequence[Process]] = tuple,
    ) -> None:
        self._reactor = reactor
        self._driver = driver
        self._settings_of = settings_of
        self._warn = warn
        self._is_forced = is_forced
        self._is_interactive = is_interactive
        self._is_collecting = True
        self._held = held
        self._late = 0  # first starts after the static part, so far
        self._preparing: PreparingProcess | None = None
        self._prepared: Prepared | None = None
        self._base: Mapping[str, str] = {}
        self._waiting: deque[WarmStart] = deque()
        self._sent: dict[int, WarmStart] = {}
        self._count = 0
        self._failures = 0
        self._later: Timer | None = None
        self._is_closed = False

    @property
    def pids(self) -> frozenset[int]:
        """The preparing process, if there is one."""
        return frozenset() if self._preparing is None else frozenset({self._preparing.pid})

    # ---- decisions

    def admit(self, process: Process) -> bool:
        """Whether it is started warm, now or when that is prepared; else start it cold."""
        start = self._start_of(process)
        if isinstance(start, str):
            process.start_kind = f"cold, because {start}"
            return False
        if self._preparing is None and not self._is_collecting and not self._is_forced:
            process.start_kind = "cold, because nothing was prepared yet"
            self._late += process.history.starts == 0
            if self._late > MANY_LATE * _processors():
                self._prepare_for([start])
            else:
                self._prepare_later(start)
            return False
        self._waiting.append(start)
        if not self._is_collecting:
            self._go_on()
        return True

    def _start_of(self, process: Process) -> WarmStart | str:
        """What is to be forked, or why it cannot be."""
        if self._is_closed or self._failures >= MOST_FAILURES:
            return "the preparing process failed"
        if process.next_debugger is not None:
            return "a debugger runs it"
        if not subreaper.is_active():
            return "the launcher adopts no orphans here"
        settings = self._settings_of(process, process.spec)
        try:
            cwd = process.spec.cwd or os.getcwd()
        except OSError:
            return "the working directory is gone"
        program = judge(process.spec, settings.env, cwd)
        if isinstance(program, str):
            return program
        folder = folder_of(program, cwd)
        if self._preparing is not None:
            why = obstacle(folder, settings.env, self._base, self._prepared)
            if why is not None:
                return why
        return WarmStart(process, program, settings, cwd=cwd, folder=folder)

    def settle(self) -> None:
        """The static part has been carried out: decide on what it has started."""
        self._is_collecting = False
        first = list(self._waiting)
        if first and not (self._is_forced or len(first) > _processors()):
            self._waiting.clear()
            for start in first:
                self._start_cold(start, "it would have waited for the preparation")
            starts = [self._start_of(process) for process in self._held()]
            held = [start for start in starts if not isinstance(start, str)]
            if len(first) + len(held) > _processors():
                self._prepare_for([*held, *first])
            else:
                self._prepare_later(*first)
        self._go_on()

    def _go_on(self) -> None:
        """Begin to prepare, or send what waits."""
        if self._preparing is None and self._waiting:
            self._prepare(list(self._waiting))
        while self._prepared is not None and self._waiting and len(self._sent) < MOST_SENT:
            self._send(self._waiting.popleft())

    # ---- preparing

    def _prepare_later(self, *starts: WarmStart) -> None:
        if self._later is None and any(self._may_restart(start.process) for start in starts):
            prepare = functools.partial(self._prepare_for, starts)
            self._later = self._reactor.call_later(SETTLED_S, prepare)

    def _may_restart(self, process: Process) -> bool:
        is_restart = process.history.starts > 0
        has_policy = process.spec.restart.mode is not RestartMode.NEVER
        return is_restart or has_policy or self._is_forced or self._is_interactive

    def _prepare_for(self, starts: Sequence[WarmStart]) -> None:
        """Prepare what these need, which do not wait for it."""
        if self._later is not None:
            self._later.cancel()
            self._later = None
        if self._preparing is None and not self._is_closed:
            self._prepare(starts)

    def _prepare(self, starts: Sequence[WarmStart]) -> None:
        """Start the preparing process, with the environment that fits most of them."""
        fitting = _fitting(starts)
        base = self._base = fitting[0].settings.env
        try:
            self._preparing = PreparingProcess(
                self._reactor, base, answered=self._answered, ended=self._ended
            )
            programs = [start.to_prepare() for start in fitting]
            ros = any(start.process.spec.ros for start in fitting)
            order = {"programs": programs, "environment": dict(base), "ros": ros}
            self._preparing.send(order)
        except OSError as error:
            self._ended(os.strerror(error.errno or 0))
            return
        self._check_again()

    def _answered(self, answer: dict[str, Any]) -> None:
        assert self._preparing is not None
        if "start" in answer:
            self._forked(self._sent.pop(answer["start"]), answer["pid"])
        elif "spare" in answer:
            spawn.started.add(answer["spare"])  # it is no orphan
        elif "ready" in answer:
            self._prepared = Prepared(**answer["ready"])
            self._check_again()
        elif "stale" in answer:
            self._replace(answer["stale"])
            return
        elif "failed" in answer:
            self._preparing.close()
            self._ended(answer["failed"])
            return
        if self._sent or self._prepared is None:
            self._preparing.watch()
        else:
            self._preparing.rest()
        self._go_on()

    def _check_again(self) -> None:
        """Start cold what cannot be forked from what is prepared, as far as that is known."""
        for start in list(self._waiting):
            why = obstacle(start.folder, start.settings.env, self._base, self._prepared)
            if why is not None:
                self._waiting.remove(start)
                self._start_cold(start, why)

    def _replace(self, changed: str) -> None:
        """What was imported has changed: prepare again for the next starts."""
        unstarted = self._drop()
        for start in unstarted:
            self._start_cold(start, f"'{changed}' has changed since it was prepared")
        self._prepare_later(*unstarted)

    def _ended(self, why: str) -> None:
        """The preparing process is gone."""
        # Its imports would fail again.
        self._failures += MOST_FAILURES if self._prepared is None else 1
        unstarted = self._drop()
        if self._is_closed:
            return
        self._warn(f"the preparing process failed, nodes are started cold: {why}")
        for start in unstarted:
            self._start_cold(start, "the preparing process failed")
        self._prepare_later(*unstarted)

    def _drop(self) -> list[WarmStart]:
        """Forget the preparing process; the starts that it has not carried out."""
        if self._preparing is not None:
            self._preparing.close()
        self._preparing, self._prepared = None, None
        unstarted = [*self._sent.values(), *self._waiting]
        self._sent.clear()
        self._waiting.clear()
        for start in unstarted:
            start.close()  # a process that was forked already ends by that
        return [start for start in unstarted if not start.is_withdrawn]

    # ---- starts

    def _send(self, start: WarmStart) -> None:
        assert self._preparing is not None
        number = self._count = self._count + 1
        try:
            fds = start.open()
            self._preparing.send(start.content(number), fds)
        except OSError:
            start.close()
            self._start_cold(start, "it could not be asked for")
            return
        finally:
            start.close_theirs()
        self._sent[number] = start

    def _forked(self, start: WarmStart, pid: int) -> None:
        """It waits for our word, or to be reaped."""
        spawn.started.add(pid)
        try:
            pidfd = os.pidfd_open(pid)
        except OSError:
            spawn.started.discard(pid)
            start.close()
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
            if not start.is_withdrawn:
                self._start_cold(start, "it could not be adopted")
            return
        if start.is_withdrawn:
            self._reactor.add_reader(pidfd, functools.partial(self._reap, pidfd))
            return
        start.process.start_kind = "warm"
        start.process.debugger = None  # a warm start has none
        self._driver.adopt(start.process, start.child(pid, pidfd))

    def _reap(self, pidfd: int) -> None:
        self._reactor.remove(pidfd)
        spawn.reap(pidfd)
        os.close(pidfd)

    def _start_cold(self, start: WarmStart, why: str) -> None:
        if not start.is_withdrawn:
            start.process.start_kind = f"cold, because {why}"
            self._driver.spawn(start.process)

    def expect(self, process: Process) -> None:
        """It is being stopped, and will be started then: let that not wait for the fork."""
        is_idle = self._prepared is not None and not (self._sent or self._waiting)
        if is_idle and not isinstance(self._start_of(process), str):
            assert self._preparing is not None
            with contextlib.suppress(OSError):
                self._preparing.send({})

    def withdraw(self, process: Process) -> bool:
        """Give up the start of a process; False if none is under way."""
        start = self._under_way(process)
        if start is None:
            return False
        start.is_withdrawn = True
        start.close()  # if it was forked already, it ends by that
        if start in self._waiting:
            self._waiting.remove(start)
        return True

    def _under_way(self, process: Process) -> WarmStart | None:
        """Its start, until it is adopted, begun cold or given up."""
        for start in (*self._waiting, *self._sent.values()):
            if start.process is process and not start.is_withdrawn:
                return start
        return None

    def is_starting(self, process: Process) -> bool:
        return self._under_way(process) is not None

    def awaits_preparation(self, process: Process) -> bool:
        """Whether its start waits for the preparation, which is not over."""
        is_over = self._prepared is not None or not (self._is_collecting or self._preparing)
        return not is_over and self.is_starting(process)

    # ---- the end

    def close(self) -> None:
        """End the preparing process. What waits for it is started cold no more."""
        self._is_closed = True
        if self._later is not None:
            self._later.cancel()
        self._drop()


def _processors() -> int:
    return len(os.sched_getaffinity(0))


def _fitting(starts: Sequence[WarmStart]) -> list[WarmStart]:
    """Most of them: those that can be forked with the environment of the first one."""
    most: list[WarmStart] = []
    for base in starts[:MOST_BASES]:
        env = base.settings.env
        found = [s for s in starts if obstacle(s.folder, s.settings.env, env, None) is None]
        if len(found) > len(most):
            most = found
        if len(most) == len(starts):
            break
    return most
