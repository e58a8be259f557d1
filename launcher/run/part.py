"""The seam of a run: what an optional feature may do, and when it is called.

A feature is a `Part`. Its row in `launcher.run.parts` says when it is made, and which options it
brings; its verbs are in `launcher.run.part_verbs`. Nothing else in a run refers to it.
"""

from __future__ import annotations

import enum

from launcher.base.model.record import Record
from launcher.base.option import Option

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any, Protocol

    from launcher.base.model.events import LoadComponent
    from launcher.base.model.run_events import Sample
    from launcher.base.model.run_options import RunOptions
    from launcher.base.model.spec import ProcessSpec
    from launcher.base.run_verb import BadCallError, Call
    from launcher.run.processes.machine_events import ReportExit
    from launcher.run.processes.process import Process
    from launcher.run.processes.process_driver import ProcessDriver
    from launcher.run.run import Run

    class Exchange(Protocol):
        """A request that is answered once, now or later, or by items of a stream."""

        on_end: Callable[[], object]  # called when the client has gone
        is_stream: bool

        def reply(self, result: Mapping[str, Any], text: Sequence[str]) -> None: ...
        def item(self, value: Mapping[str, Any]) -> None: ...
        def fail(self, problem: BadCallError) -> None: ...

    class VerbRequest(Protocol):
        """A call of a verb of a part; the function that serves it may raise BadCallError."""

        run: Run
        call: Call
        exchange: Exchange

        # The processes that these words name, by default those of the call; all if there are none.
        def chosen(self, names: Sequence[str] | None = None) -> list[Process]: ...


class Part:
    """An optional feature of a `run`; a hook that it does not have does nothing.

    `no_reload` says why the launch file of a run with this part cannot be evaluated again.
    """

    no_reload = ""

    def __init__(self, run: Run) -> None:
        self.run = run

    # ---- the run

    def driver(self) -> ProcessDriver | None:
        """What drives the processes of the run, if that is for this part to say."""
        return None

    def open(self, begin: Callable[[], None]) -> bool:
        """Whether the run begins when this part calls `begin`; at most one part may say so."""
        return False

    def holds_run(self) -> bool:
        """Whether the run must not end for want of processes."""
        return False

    def settled(self) -> None:
        """The static part of the launch file was carried out."""

    def begin(self) -> None:
        """Called once, in an idle moment, if the part was made `BEGUN` or `SERVED`."""

    def follow(self, before: RunOptions) -> None:
        """A reload has read options that differ from those `before`."""

    def stopping(self) -> None:
        """The run is being stopped."""

    def skip_grace(self) -> None:
        """A user does not want to wait any longer for the end of the run."""

    def end_helpers(self) -> None:
        """End helper processes that must not count as leftovers; may be called twice."""

    def finish(self, done: Callable[[], None]) -> bool:
        """Whether it looks for leftovers elsewhere, and calls `done` when that is over."""
        return False

    def conclude(self, *, is_orderly: bool) -> None:
        """All processes have ended; the summary follows. After an exception it is not orderly."""

    def close(self) -> None:
        """The last lines of the run are written."""

    # ---- its processes

    def refuses(self, spec: ProcessSpec) -> bool:
        """Whether it is not to be started, which is reported."""
        return False

    def adding(self, process: Process) -> None:
        """A new process of the launch file, before its first start."""

    def added(self, process: Process) -> None:
        """Its start was requested."""

    def adopted(self, process: Process) -> None:
        """A reload has given it another spec."""

    def dropped(self, process: Process) -> None:
        """The launch file does not have it any more, and it has ended, if it can be ended."""

    def started(self, process: Process) -> None:
        """Its program runs."""

    def ended(self, process: Process, end: ReportExit) -> None:
        """It has exited, or could not be started."""

    def loaded(self, effect: LoadComponent, full_name: str) -> None:
        """A container has loaded a node."""

    def changed(self) -> None:
        """The state of a process may have changed."""

    # ---- what is known of them

    def greeting(self) -> Mapping[str, object]:
        """Fields for the first line to each client of the control socket."""
        return {}

    def samples(self) -> Mapping[str, Sample]:
        """Resources of the processes that it measures, by name of process."""
        return {}

    def sampled(self, samples: Mapping[str, Sample], processes: Mapping[str, Process]) -> None:
        """The resources of running processes, by name."""

    def row(self, process: Process) -> Mapping[str, object]:
        """Fields for `ps`."""
        return {}

    def info(self, process: Process) -> Mapping[str, object]:
        """More fields for `info`."""
        return {}


class StartStage(Part):
    """A part through which starts go, from stage to stage, until the last one spawns them."""

    def admit(self, process: Process) -> None:
        """Keep it, or `pass_on`, now or later."""
        self.pass_on(process)

    def pass_on(self, process: Process) -> None:
        """Let its start go on."""
        self.run.driver.pass_on(process, self)

    def expect(self, process: Process) -> None:
        """It is being stopped, and will be started when it has ended."""

    def withdraw(self, process: Process) -> bool:
        """Drop a process that is kept here, which shall not start; False if it is not here."""
        return False

    def waits(self, process: Process) -> bool:
        """Whether it waits here for other processes."""
        return False

    def skip(self, process: Process) -> None:
        """A user starts it: it does not wait for other processes any more."""

    def is_starting(self, process: Process) -> bool:
        """Whether this stage starts its program in place of the last one."""
        return False

    def awaits_preparation(self, process: Process) -> bool:
        """Whether a start in this stage has to wait for a preparation."""
        return False


class When(enum.Enum):
    """When a part is made that is wanted."""

    FIRST = enum.auto()  # before the first start, and before the run has its driver
    BEGUN = enum.auto()  # after the static part of the launch file
    SERVED = enum.auto()  # when there is a control socket
    ASKED = enum.auto()  # by `RunParts.need` only, which makes the others ahead of their time, too


# Titles of options of a run in its help, in this order.
OPTION_GROUPS = (
    STARTS := "options about starts",
    RESTARTS := "options about restarts and the end of the run",
    OUTPUT := "options about output",
    LOOKING := "options to look and record",
    CONTROL := "options about control",
    RESOURCES := "options about resources",
    HOSTS := "options about other hosts",
    DEVELOPMENT := "options for development and debugging",
)


class PartRow(Record):
    """A part, as `module:Class`.

    `wanted(run)`: whether the part is made at `when`, plus `delay_s`. The modules in `imports` are
    imported before, one in each idle moment, so that output of a process waits for one at most.
    `options` are those of a command line, shown in the `group` of OPTION_GROUPS; if one of them is
    given, `check` is called with all.
    """

    part: str
    when: When = When.BEGUN
    wanted: Callable[[Run], object] = lambda run: True
    delay_s: float = 0.0
    imports: tuple[str, ...] = ()
    group: str = ""
    options: tuple[Option, ...] = ()
    check: str = ""
