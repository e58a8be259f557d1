"""What injections do to a process or the machine, and how that is undone."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Mapping

from launcher.run.helpers.json_lines import JsonLinesProcess, own_end
from launcher.run.processes.machine_events import ProcessState
from launcher.run.requests.process_signals import SUSPEND_POLL_S, SUSPEND_TIMEOUT_S
from launcher.smoke.inject.grammar import Injection

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.processes.process import Process
    from launcher.run.run import Run

STRESS = "launcher.smoke.inject.stress"
END_S = 2.0  # for a separate process that is to end; then it is killed

Report = Callable[["str | None"], None]  # why it is not possible, or None


class Effect:
    """Of one injection, into a process or, without one, the machine.

    `begin` calls `acts` right before the first thing that can be seen, and `done` when it is in
    force, or with what makes it impossible. `on_lost` is called with a reason if it ends by itself
    later. `survives`: the exit of the process does not end it. `counts_beginning`: its time counts
    from `acts`, and not from `done`, which may come late: on a machine that has become slow by it.
    """

    survives = False
    counts_beginning = False

    def __init__(self, run: Run, injection: Injection, process: Process | None) -> None:
        self.run = run
        self.injection = injection
        self.process = process
        self.on_lost: Callable[[str], object] = lambda reason: None

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        raise NotImplementedError

    def end(self, done: Callable[[], None]) -> None:
        """Undo it, and call `done` when everything is as before."""
        done()

    def close(self) -> None:
        """The run is over: undo what would outlive it, and do not wait."""

    def broken_by(self) -> str:
        """What a user has done to the process meanwhile, so that it cannot go on."""
        return ""

    @property
    def target(self) -> Process:
        """The process; only kinds of the machine do without."""
        assert self.process is not None
        return self.process

    def signal(self, signum: signal.Signals) -> None:
        """Signal the group of the process as from outside: the launcher has not done it."""
        process = self.target
        if process.host is not None:
            self.run.driver.signal(process, signum)
        elif process.child is not None:
            process.child.signal_group(signum)


class KillEffect(Effect):
    """SIGKILL, which the launcher takes for a crash."""

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        acts()
        self.run.before_kill()
        self.signal(signal.SIGKILL)
        done(None)


class PauseEffect(Effect):
    """SIGSTOP until the end; it is undone by a stop, and by `resume`, too."""

    _was_halted = False

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        acts()
        self.signal(signal.SIGSTOP)
        child, until_s = self.target.child, self.run.reactor.now() + SUSPEND_TIMEOUT_S

        def check() -> None:
            is_over = self.target.child is not child or self.run.reactor.now() > until_s
            self._was_halted = self.target.host is None and self.target.is_halted
            if self._was_halted or is_over or self.target.host is not None:
                done(None)
            else:
                self.run.reactor.call_later(SUSPEND_POLL_S, check)

        check()

    def end(self, done: Callable[[], None]) -> None:
        self.close()
        done()

    def close(self) -> None:
        if not self.target.machine.is_suspended or self.target.host is not None:
            self.signal(signal.SIGCONT)

    def broken_by(self) -> str:
        process = self.target
        is_resumed = self._was_halted and not process.is_halted
        return _broken_by(process) or ("it was resumed" if is_resumed else "")


class HelperEffect(Effect):
    """A separate process does it, which reads one JSON object and answers with others.

    `request` is that object, and `heard` gets the answers; a subclass calls `in_force` or `fail`.
    """

    program = ""
    pid: int | None = None
    started_s = 0.0

    def __init__(self, run: Run, injection: Injection, process: Process | None) -> None:
        super().__init__(run, injection, process)
        self._helper: JsonLinesProcess | None = None
        self._done: Report | None = None
        self._on_exit: Callable[[], None] | None = None
        self._problem = ""
        self.acts: Callable[[], None] = lambda: None

    def request(self) -> dict[str, Any]:
        raise NotImplementedError

    def heard(self, answer: dict[str, Any]) -> None:
        raise NotImplementedError

    def exited(self, code: int) -> None:
        """The process has ended."""

    @property
    def is_beginning(self) -> bool:
        return self._done is not None

    def start(self, acts: Callable[[], None], done: Report, env: Mapping[str, str]) -> None:
        self.acts, self._done = acts, done
        self.started_s = time.time()
        try:
            self._helper = JsonLinesProcess(
                self.run.reactor,
                self.program,
                own_end(env),
                on_message=self._heard,
                on_end=self._ended,
            )
        except OSError as error:
            self._answer(f"cannot start a process for it: {error.strerror}")
            return
        self.pid = self._helper.pid
        self._helper.send(self.request())

    def _heard(self, answer: dict[str, Any]) -> None:
        if "error" in answer:
            self._problem = answer["error"]  # it ends now
        else:
            self.heard(answer)

    def in_force(self) -> None:
        self._answer(None)

    def _answer(self, problem: str | None) -> None:
        done, self._done = self._done, None
        if done is not None:
            done(problem)

    def fail(self, problem: str) -> None:
        """Undo it, since it cannot be, or cannot go on."""
        self._problem = problem
        self.undo(self._failed)

    def _failed(self) -> None:
        if self._done is not None:
            self._answer(self._problem)
        else:
            self.on_lost(self._problem)

    def _ended(self, code: int, line: str) -> None:
        self._helper = None
        self.exited(code)
        if self._on_exit is not None:
            self._on_exit()
        else:
            self.fail(self._problem or line or f"its process has ended ({code})")

    def end(self, done: Callable[[], None]) -> None:
        def undone() -> None:
            self._answer("it was over before it was in force")
            done()

        self.undo(undone)

    def undo(self, done: Callable[[], None]) -> None:
        """Let the process end, and call `done` then."""
        if self._helper is None:
            done()
        else:
            self._on_exit = done
            self._helper.close_input()
            self.run.reactor.call_later(END_S, self._kill)

    def _kill(self) -> None:
        if self._helper is not None:
            self._ended(self._helper.close(), "")

    def close(self) -> None:
        if self._helper is not None:
            self.exited(self._helper.close())
            self._helper = None


class StressEffect(HelperEffect):
    """A process that takes CPU, memory or disk; what it uses counts as that of the process."""

    program = STRESS
    counts_beginning = True
    _has_begun = False

    def request(self) -> dict[str, Any]:
        child = None if self.process is None else self.process.child
        return {
            "kind": self.injection.kind,
            "pid": child and child.pid,
            "for_s": self.injection.for_s,
            "folder": self.run.log_dir,
            **dict(self.injection.values),
        }

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        self.start(acts, done, self.run.env)
        if self.process is not None and self.pid is not None:
            self.process.guests.add(self.pid)

    def heard(self, answer: dict[str, Any]) -> None:
        if not self._has_begun:
            self._has_begun = True
            self.acts()
        if "ready" in answer:
            self.in_force()

    def exited(self, code: int) -> None:
        if self.process is not None and self.pid is not None:
            self.process.guests.discard(self.pid)


class SlowEffect(StressEffect):
    """SIGSTOP and SIGCONT in turn, from a separate process, which counts as nobody's."""

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        self.start(acts, done, self.run.env)

    def exited(self, code: int) -> None:
        super().exited(code)
        # It may have been killed; or it has continued what a user has suspended meanwhile.
        is_suspended = self.target.machine.is_suspended
        self.signal(signal.SIGSTOP if is_suspended else signal.SIGCONT)

    def broken_by(self) -> str:
        return "it was paused" if self.target.machine.is_suspended else _broken_by(self.target)


def _broken_by(process: Process) -> str:
    return "it is being stopped" if process.machine.state is ProcessState.STOPPING else ""
