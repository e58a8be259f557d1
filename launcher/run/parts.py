"""The table of the parts of a run, and the parts that one run has."""

from __future__ import annotations

import enum
import functools
import os

from launcher.base.by_name import lazy, load
from launcher.base.command_line import Option, count, option, positive_seconds, seconds
from launcher.base.errors import UsageError
from launcher.base.model.options import RunOptions
from launcher.base.model.record import Record
from launcher.base.run_verb import Verb
from launcher.run.part import Part, StartStage

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from typing import TypeVar

    from launcher.run.run import Run

    P = TypeVar("P", bound=Part)


def _discovery(word: str) -> str:
    if word not in DISCOVERY_MODES:
        raise ValueError(f"'{word}' is not one of {', '.join(DISCOVERY_MODES)}")
    return word


class When(enum.Enum):
    """When a part is made that is wanted: before the first start, after the static part of the
    launch file, or when there is a control socket. Others are made when they are asked for.
    """

    FIRST = enum.auto()
    BEGUN = enum.auto()
    SERVED = enum.auto()


class Row(Record):
    """A part, as `module:Class`.

    `wanted` says whether a run has it `when` that is, `delay_s` later; modules that its `imports`
    name are imported before, one at a time, so that a line of a process waits for one at most.
    `options` are those of a command line; with one of them, `check` is called with all.
    """

    part: str
    when: When = When.BEGUN
    wanted: Callable[[Run], object] | None = None
    delay_s: float = 0.0
    imports: tuple[str, ...] = ()
    options: tuple[Option, ...] = ()
    check: str = ""
    verbs: tuple[Verb, ...] = ()


# Doors of wings for the evaluation of a launch file, and the program of composed nodes.
prepared_hosts = lazy("launcher.hosts.launching.preparation:HostsPreparation")
planned_hosts = lazy("launcher.hosts.launching.planned:PlannedHosts")
open_node = lazy("launcher.ros.helpers.spinning_node:SpinningNode")
COMPOSED = "launcher.ros.composed"

DISCOVERY_MODES = ("multicast", "peers", "server")
DISCOVERY = option(
    "--discovery MODE",
    "how nodes on several hosts find each other (default: as the hosts file or the environment "
    "says)",
    choices=DISCOVERY_MODES,
)
COMPOSE = option(
    "--compose NAME",
    "run the Python nodes that match in one process, which needs less memory; NAME may be a "
    "pattern",
    default=(),
    repeat="all",
)
SKIP_HOST = option(
    "--skip-host NAME",
    "do without a host of the hosts file: what would run there is not started; NAME may be a "
    "pattern",
    name="skip_hosts",
    default=(),
    repeat="all",
)
RECORDING = (
    option(
        "--record[=all]",
        "keep the last messages of all topics in memory, and write them with logs and events when "
        "a process dies, and at `snapshot`; all: write every message into the folder of the run",
        lazy("launcher.bag.recording:parse_mode"),
        repeat="once",
    ),
    option(
        "--record-keep 60s,256M",
        "how long --record keeps messages, and how much memory they may take",
        lazy("launcher.bag.recording:parse_keep"),
        repeat="once",
    ),
    option(
        "--record-topics REGEX",
        "record only topics whose names it matches",
        lazy("launcher.bag.recording:parse_topics"),
    ),
)


def page_options(prefix: str) -> tuple[Option, ...]:
    """Options about the page in the browser, such as `--web-port` for the prefix `web-`."""
    return (
        option(
            f"--{prefix}port N",
            "port of the page (default: 8770, or any if that is taken; 0: any)",
            lambda word: count(word, 0, 65535),
            repeat="once",
        ),
        option(
            f"--{prefix}host ADDRESS",
            "address to listen on (default: 127.0.0.1); others can be reached from other machines",
            repeat="once",
        ),
        option(
            f"--{prefix}tls CERT,KEY",
            "files in PEM: encrypt the page, for an address that others can reach",
            lazy("launcher.web.option:parse_tls"),
            repeat="once",
        ),
        option(
            f"--{prefix}token FILE",
            "use the token in this file in place of a new one",
            os.path.abspath,
            repeat="once",
        ),
        option(f"--{prefix}read-only", "the page only shows, and changes nothing"),
    )


DRY_RUN = option("--dry-run", "only show what would be done")
STATE = option("STATE", "on or off")

# In the order in which parts hear of events; they are closed in the opposite one.
ROWS = (
    Row("launcher.run.monitor.housekeeping:Housekeeping", wanted=lambda run: True),
    Row(
        "launcher.hosts.engine.fleet:Fleet",
        When.FIRST,
        lambda run: run.launched.hosts is not None,
        options=(
            option(
                "--hosts FILE", "run processes on other hosts, as this file says", repeat="once"
            ),
            SKIP_HOST,
            option(
                "--discovery MODE",
                "how the nodes of several hosts find each other: multicast, peers or server",
                _discovery,
                repeat="once",
            ),
        ),
        verbs=(
            Verb(
                "detach",
                "end the run here, and let the processes on other hosts run on",
                serve="launcher.hosts.engine.detach_verb:serve",
            ),
        ),
    ),
    Row(
        "launcher.run.compose.members:ComposedMembers",
        When.FIRST,
        lambda run: run.options.compose,
        options=(COMPOSE,),
    ),
    Row("launcher.run.ready.gate:ReadyGate", When.FIRST, lambda run: run.options.start_rules),
    Row(
        "launcher.run.starts.pacing:StartPacing",
        When.FIRST,
        lambda run: run.options.stagger_s > 0 or run.options.max_starting is not None,
        options=(
            option(
                "--stagger S", "start processes at least S seconds apart", seconds, name="stagger_s"
            ),
            option(
                "--max-starting N",
                "let at most N processes start at the same time",
                lambda word: count(word, 1),
            ),
        ),
    ),
    Row(
        "launcher.run.starts.warm:WarmStarts",
        When.FIRST,
        lambda run: run.options.warm is not False,
        options=(
            option(
                "--warm",
                "start all Python programs warm, from a process that has imported what they need; "
                "without --warm and --cold, Python nodes where that is faster",
                value=True,
            ),
            option("--cold", "start no process warm", name="warm", value=False),
        ),
    ),
    Row(
        "launcher.run.time_limit:TimeLimit",
        When.FIRST,
        lambda run: run.options.timeout_s is not None,
        options=(
            option(
                "--timeout S", "end the run after S seconds", positive_seconds, name="timeout_s"
            ),
        ),
    ),
    Row(
        "launcher.run.quiet_limit:QuietLimit",
        When.FIRST,
        lambda run: run.options.stop_after_quiet_s is not None,
        options=(
            option(
                "--stop-after-quiet SECONDS",
                "end the run when its processes have written nothing for so long",
                positive_seconds,
                name="stop_after_quiet_s",
            ),
        ),
    ),
    Row(
        "launcher.run.monitor.enforcement:BudgetEnforcement",
        When.FIRST,
        lambda run: run.options.has_budgets,
        options=(
            option(
                "--budget NAME:cpu=80%,memory=200M,threads=N,fds=N,for=S,"
                "action=warn|restart|stop-run",
                "limit what a process may use, checked once a second",
                name="budgets",
            ),
        ),
    ),
    Row(
        "launcher.run.plan_file:PlanFile",
        When.FIRST,
        lambda run: run.log_dir is not None or run.options.name_processes,
    ),
    Row("launcher.run.requests.process_control:ProcessControl"),
    Row(
        "launcher.run.helpers.parameter_checks:ParameterChecks",
        wanted=lambda run: run.options.check_parameters,
        options=(
            option(
                "--no-parameter-check",
                "do not warn of parameters that were set and that their nodes do not declare",
                name="check_parameters",
                value=False,
            ),
        ),
    ),
    Row(
        "launcher.run.reload.reload:Reloader",
        verbs=(
            Verb(
                "reload [--dry-run]",
                "evaluate the launch file again: start what is new, stop what is gone, restart "
                "what has changed",
                (DRY_RUN,),
                serve="launcher.run.reload.verb:serve",
            ),
        ),
    ),
    Row(
        "launcher.run.watch.watching:Watching",
        wanted=lambda run: run.options.watch,
        delay_s=0.05,
        options=(
            option(
                "--watch",
                "restart processes when their source or parameter files change, and reload the "
                "launch file when that does",
            ),
        ),
        check="launcher.run.watch.option:check",
        verbs=(
            Verb(
                "watch [on|off] [NAME ...]",
                "restart processes when their files change; without on and off, show what is "
                "watched",
                (STATE,),
                serve="launcher.run.watch.verb:serve",
            ),
        ),
    ),
    Row(
        "launcher.run.monitor.responsiveness:Responsiveness",
        wanted=lambda run: run.options.responsive,
        delay_s=2.0,  # nodes are starting before, and cannot be late
        options=(
            option(
                "--responsive",
                "warn of nodes that do not answer any more, with their stacks (30 MB; `top` does "
                "it, too)",
            ),
        ),
    ),
    Row(
        "launcher.run.stacks.stacks:Stacks",
        verbs=(
            Verb(
                "stack NAME ... [--native] [--locals]",
                "print the Python stacks of all threads of processes",
                (
                    option("--native", "with the calls of C and C++ code between them"),
                    option("--locals", "with the local variables of each call"),
                ),
                serve="launcher.run.stacks.verb:serve",
            ),
            Verb(
                "debug NAME [--port N] [--no-wait]",
                "start or restart a Python process under debugpy, for an editor to attach",
                (
                    option(
                        "--port N",
                        "listen at this port of 127.0.0.1 (default: a free one)",
                        count,
                        kind="count",
                    ),
                    option(
                        "--no-wait",
                        "run at once, without waiting for an editor",
                        name="wait",
                        value=False,
                    ),
                ),
                serve="launcher.run.debug.verb:serve",
            ),
        ),
    ),
    Row(
        "launcher.run.helpers.logger_levels:LoggerLevels",
        verbs=(
            Verb(
                "loglevel NAME [LOGGER] [LEVEL]",
                "set from which level on nodes log; without LEVEL, print it",
                behind=(
                    option("[LOGGER]", "a logger, as in its lines; default: that of the node"),
                    option("[LEVEL]", "debug, info, warn, error or fatal"),
                ),
                serve="launcher.run.helpers.loglevel:serve",
            ),
        ),
    ),
    Row(
        "launcher.web.web_page:WebPage",
        When.SERVED,
        lambda run: run.options.web,
        options=(
            option(
                "--web",
                "serve a page in the browser that shows and controls this run (docs/web.md)",
            ),
            *page_options("web-"),
        ),
        check="launcher.web.option:check",
        verbs=(
            Verb(
                "web",
                "open the page of this run in the browser",
                shell=False,
                serve="launcher.web.link_verb:serve",
            ),
        ),
    ),
    Row(
        "launcher.control.socket_part:ControlSocket",
        wanted=lambda run: run.options.control,
        delay_s=0.05,
        imports=("socket", "launcher.control.verbs", "launcher.control.service"),
        options=(
            option(
                "--no-control",
                "open no socket for other shells; implies --no-console",
                name="control",
                value=False,
            ),
        ),
    ),
    Row(
        "launcher.bag.flight_recorder:FlightRecorder",
        When.SERVED,
        lambda run: run.options.record is not None,
        options=RECORDING,
        check="launcher.bag.recording:check",
        verbs=(
            Verb(
                "snapshot [REASON]",
                "write the last messages, logs and events of a run with --record",
                (option("REASON", "why, for the index of the snapshot"),),
                serve="launcher.bag.snapshot_verb:serve",
            ),
        ),
    ),
    Row(
        "launcher.ros.bridge_process:RosBridge",
        When.SERVED,
        lambda run: run.options.ros,
        options=(
            option(
                "--ros",
                "start a node /launcher that publishes /diagnostics and offers services to start, "
                "stop and restart processes, for rqt and Foxglove",
            ),
        ),
        check="launcher.run.parts:check_bridge",
    ),
    Row(
        "launcher.control.console_process:ConsoleProcess",
        When.SERVED,
        lambda run: run.options.console and run.screen.is_tty and os.isatty(0),
        delay_s=0.3,  # leaves the processor to processes that are starting
        options=(
            option(
                "--no-console", "disable the prompt and the status bar", name="console", value=False
            ),
        ),
    ),
)
_RANKS = {row.part: rank for rank, row in enumerate(ROWS)}
PART_OPTIONS = tuple(option for row in ROWS for option in row.options)


def check_bridge(options: RunOptions) -> None:
    """UsageError without the control socket."""
    if not options.control:
        raise UsageError("--ros needs the control socket and excludes --no-control")


def check_options(options: RunOptions) -> None:
    """UsageError for options of parts that exclude each other, or that lack a library."""
    for row in ROWS:
        if row.check and any(
            getattr(options, one.name) != getattr(RunOptions, one.name) for one in row.options
        ):
            load(row.check)(options)


class Parts:
    """The parts of one run, in the order of the table."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._parts: tuple[Part, ...] = ()
        self.stages: Sequence[StartStage] = ()

    def __iter__(self) -> Iterator[Part]:
        return iter(self._parts)

    def find(self, kind: type[P]) -> P | None:
        """The part of this class, if it was made."""
        return next((part for part in self._parts if type(part) is kind), None)

    def need(self, kind: type[P]) -> P:
        """The part of this class, which is made with the first request."""
        found = self.find(kind)
        if found is not None:
            return found
        part = kind(self._run)
        self._parts = tuple(sorted((*self._parts, part), key=_rank))
        self.stages = [one for one in self._parts if isinstance(one, StartStage)]
        return part

    def _wanted(self, when: When) -> list[Row]:
        rows = (row for row in ROWS if row.when is when)
        return [row for row in rows if row.wanted is not None and row.wanted(self._run)]

    def make_first(self) -> None:
        """Make the parts that are wanted before the first start; UsageError."""
        for row in self._wanted(When.FIRST):
            self.need(load(row.part))

    def begin(self, when: When) -> None:
        """Make those that are wanted from then on, in idle moments."""
        for row in self._wanted(when):
            begin = functools.partial(self._begin, row)
            if row.delay_s:
                self._run.reactor.call_later(row.delay_s, begin)
            else:
                begin()

    def _begin(self, row: Row) -> None:
        when_idle = self._run.reactor.when_idle
        for name in row.imports:
            when_idle(functools.partial(__import__, name))
        when_idle(lambda: self.need(load(row.part)).begin())


def _rank(part: Part) -> int:
    kind = type(part)
    return _RANKS[f"{kind.__module__}:{kind.__qualname__}"]
