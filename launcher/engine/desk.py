"""Desk: where a person sits: what there is to know about a run, and what can be done with it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

from launcher.engine.chronicle import Chronicle
from launcher.engine.ending import Ending
from launcher.engine.keeper import Keeper
from launcher.engine.operator import Operator
from launcher.engine.process import Process
from launcher.engine.reactor import Reactor
from launcher.engine.views import Views

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

    from launcher.engine.caretaker import Caretaker
    from launcher.engine.core import Core
    from launcher.engine.resources import Sample


class Desk:
    """One for a run. It is made when somebody opens it, and costs nothing until then.

    `core` knows what was asked for; `on_process` is called with each process that is started for
    the first time.
    """

    def __init__(
        self,
        reactor: Reactor,
        chronicle: Chronicle,
        keeper: Keeper,
        ending: Ending,
        core: Core,
        *,
        processes: Mapping[int, Process],
        caretaker: Caretaker,
        log_path: Path | None,
    ) -> None:
        self.reactor = reactor
        self.chronicle = chronicle
        self.core = core
        self.log_path = log_path
        self.operator = Operator(
            reactor, keeper, chronicle, is_stopping=lambda: self._ending.has_begun
        )
        warn = functools.partial(chronicle.say, "WARNING", "launch")
        self.views = Views(processes.values, warn)
        self.on_process: Callable[[Process], None] = lambda process: None
        self._ending = ending
        self._processes = processes
        self.caretaker = caretaker

    @property
    def processes(self) -> list[Process]:
        """All of the run, in order of first start."""
        return list(self._processes.values())

    @property
    def is_stopping(self) -> bool:
        """Whether the run as a whole is being stopped."""
        return self._ending.has_begun

    def sample_of(self, process: Process) -> Sample | None:
        """What it used last; None while that is not known, or if it does not run."""
        sample = self.caretaker.samples.get(process.name)
        if process.child is None or sample is None or sample.pid != process.child.pid:
            return None
        return sample

    def adopt(self, process: Process) -> None:
        """Take notice of a process that is new."""
        self.views.adopt(process)
        self.on_process(process)

    def quit(self, reason: str) -> None:
        """Stop the run, in order."""
        self.chronicle.note("asked", verb="quit")
        self._ending.stop_soon(reason)
