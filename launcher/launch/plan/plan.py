"""What a launch file would start: processes, loads, logs, and when each of them comes."""

from __future__ import annotations

from launcher.base.errors import LaunchFileError
from launcher.base.model import events as model
from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec
from launcher.language.configurations import ROS_NAMES
from launcher.language.events.process import ProcessStarted

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.model.supervision import StartRule
    from launcher.language.context import LaunchContext
    from launcher.language.description import LaunchDescription
    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.interpreter.run_host import Quirk
    from launcher.language.interpreter.trace import Visit


class Occasion:
    """An event of a process or node, whose time is known only in a run.

    `time_s` is its time in the plan; `process` is the index of what it is about, and `before` the
    stamp of its start. Without a process it is about the action of the event.
    """

    def __init__(self, event: Any, time_s: float, process: int | None, before: Stamp) -> None:
        self.event = event
        self.time_s = time_s
        self.process = process
        self.before = before

    @property
    def is_start(self) -> bool:
        """Whether it comes at the time of `before`."""
        return isinstance(self.event, ProcessStarted) and self.time_s == self.before.time_s


class Stamp(Record):
    """When: virtual seconds, the phase, and the index of the process whose exit was the cause.

    `since_cause_s` is the time from that exit. `occasion` is the last one before; None: the start
    of the run, after which only timers came.
    """

    time_s: float
    phase: str
    cause: int | None
    since_cause_s: float | None = None
    occasion: Occasion | None = None

    @property
    def origin(self) -> Occasion | None:
        """From what the time counts in a run: starts of processes come when they are requested."""
        occasion = self.occasion
        while occasion is not None and occasion.is_start:
            occasion = occasion.before.occasion
        return occasion


class PlannedProcess(Record):
    """A process, and its restart settings as in the launch file."""

    spec: ProcessSpec
    respawn: bool
    respawn_delay: float | None
    respawn_max_retries: Any
    stamp: Stamp


class PlanError(Record):
    """The error that ended the evaluation; `stage`: `load` or `run`; `kind`: ROS 2's exception."""

    kind: str
    message: str
    stage: str
    phase: str
    fault: LaunchFileError


class Plan:
    """The processes, loads, transitions, logs and visits of a launch file."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.environment: dict[str, str] = {}
        self.arguments: list[Any] | None = None
        self.arguments_error: str | None = None
        self.declared: dict[str, str] = {}
        self.processes: list[PlannedProcess] = []
        self.loads: list[tuple[model.LoadRequest, Stamp]] = []
        self.lifecycle: list[tuple[model.StateRequest, Stamp]] = []
        self.logs: list[tuple[str, Stamp]] = []
        self.shutdowns: list[tuple[str, Stamp]] = []
        self.visits: list[Visit] = []  # caused by events; the others are below them
        self.warnings: tuple[Quirk, ...] = ()
        self.empty_run: str | None = None  # why no process would be started
        # Only with scopes: what conditions have kept away, and whether that is all.
        self.switched_off: tuple[ProcessSpec, ...] = ()
        self.is_off_complete = True
        self.names_read: frozenset[str] = frozenset()
        self.reads_arguments = False  # of the command line, by itself
        self.uses: tuple[tuple[str, FileLine], ...] = ()  # see LaunchSession
        self.distribution: str | None = None  # of ROS 2: the target, else the installed one
        self.absorbed: frozenset[str] = frozenset()  # composed into the process of another
        self.start_rules: tuple[StartRule, ...] = ()  # of a supervision file
        # For the analysis of errors.
        self.description: LaunchDescription | None = None
        self.context: LaunchContext | None = None
        self.error: PlanError | None = None

    @property
    def known_names(self) -> frozenset[str]:
        """Argument names that have an effect: declared, read by the launch file, or ROS 2's own.

        Contains ALL_NAMES if the launch file reads all configurations.
        """
        listed = [argument.name for argument in self.arguments or ()]
        return frozenset([*listed, *self.declared, *self.names_read, *ROS_NAMES])
