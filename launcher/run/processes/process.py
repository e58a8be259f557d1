"""The state of one process of the run: spec, state machine, child, output."""

from __future__ import annotations

import os

from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec, Sink, replaces
from launcher.base.text import escape
from launcher.output.lines import Block, LogRing, for_terminal, texts_of
from launcher.posix import proc
from launcher.posix.reactor import Timer
from launcher.posix.spawn import Child
from launcher.run.processes.machine import ProcessMachine

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Protocol

    from launcher.base.model.events import Outcome
    from launcher.base.model.run_options import RunOptions
    from launcher.output.filters import LineFilter
    from launcher.run.compose.group_output import GroupOutput
    from launcher.run.debug.debugger import Debugger
    from launcher.run.output.stream import Stream
    from launcher.run.processes.machine_events import ReportExit

    class Elsewhere(Protocol):
        """Another host, on which a process runs."""

        @property
        def name(self) -> str: ...

        @property
        def is_gone(self) -> bool: ...

        # Since when it cannot be reached; None while it can.
        @property
        def unreachable_s(self) -> float | None: ...


LAST_BYTES = 4096  # of each of its last lines, in the report on a failure


class History:
    """What the summary at the end shows of all lives of a process.

    `deaths` are exits that were not requested and failed, `first_death` is the outcome of the
    first; `exits` are clean ones that led to a restart. `odd_code` is the first unusual exit code
    after a stop. `refusals` are starts that failed, but for those of which a stop was requested
    meanwhile. `unshown_lines` are those that went to log files only. `run_s` is the sum of all
    lives, `peak_uss` the largest sample in bytes. `core_note` is about the core file of the last
    death, `hang` the stack of the last life that ended while its node did not answer.
    """

    __slots__ = (
        "core_note",
        "deaths",
        "exits",
        "first_death",
        "first_error",
        "hang",
        "odd_code",
        "peak_uss",
        "refusals",
        "run_s",
        "starts",
        "unshown_lines",
    )

    def __init__(self) -> None:
        self.starts = self.refusals = self.unshown_lines = 0
        self.deaths = self.exits = 0
        self.first_death: Outcome | None = None
        self.odd_code: int | None = None
        self.first_error = self.core_note = ""
        self.hang: tuple[str, ...] = ()
        self.run_s = 0.0
        self.peak_uss: int | None = None

    def sampled(self, uss_bytes: int | None) -> None:
        if uss_bytes is not None:
            self.peak_uss = max(self.peak_uss or 0, uss_bytes)


class Silence:
    """A node does not answer: for how long, and what its process was doing when it was noticed."""

    def __init__(self) -> None:
        self.silent_s = self.reported_s = 0.0
        self.stack: tuple[str, ...] = ()

    def report(self, silent_s: float, now: float) -> None:
        self.silent_s, self.reported_s = silent_s, now

    def elapsed_s(self, now: float) -> float:
        return self.silent_s + now - self.reported_s


class Process:
    """A spec, its state machine, and the running child if there is one.

    `number` counts from 0 in order of first start; it picks the colour. `filter` chooses the lines
    that are shown (None: all); `on_lines` is called with all of them. `last_end` is its last exit,
    at `ended_wall_s`; `begun_wall_s` is when its last start began. `host` is where it runs (None:
    on this machine), `words_there` and `folder_there` what it runs there; `is_abandoned`: the run
    has ended without it. `is_gone`: the launch file does not have it any more. `is_replaced`: it is
    being stopped for a new version of its files, of which the launch file gets no event.
    `debugger` is that of its child, `next_debugger` that of its next start only. `start_kind` says
    how it was started last: `warm`, or `cold, because ...`; empty if only cold was possible.
    `awaited_facts` must hold until it counts as ready, as texts.
    `answers`: its node is being asked, and has answered; `silence`: it does not any more.
    `guests` lead sessions whose resources count as its own.
    """

    def __init__(self, process_id: int, spec: ProcessSpec, *, number: int, prefix: bytes) -> None:
        self.process_id = process_id
        self.spec = spec
        self.number = number
        self.prefix = prefix
        self.machine = ProcessMachine(spec.restart, spec.stop)
        self.child: Child | None = None
        self.host: Elsewhere | None = None
        self.words_there: tuple[str, ...] = ()
        self.folder_there: str | None = None
        self.is_abandoned = self.is_gone = self.is_replaced = False
        self.debugger: Debugger | None = None
        self.next_debugger: Debugger | None = None
        self.start_kind = ""
        self.answers = False
        self.awaited_facts: tuple[str, ...] = ()
        self.silence: Silence | None = None
        self.guests: set[int] = set()
        self.streams: dict[int, Stream] = {}
        self.ring = LogRing()
        self.filter: LineFilter | None = None
        self.on_lines: Callable[[bytes], None] | None = None
        self.history = History()
        self.last_end: ReportExit | None = None
        self.ended_wall_s = 0.0
        self.begun_wall_s = 0.0
        self.timer: Timer | None = None
        self.idle_timer: Timer | None = None
        self.group: GroupOutput | None = None  # of a process with several nodes
        self._halted_pid: int | None = None  # of the child that was suspended when last looked at

    @property
    def name(self) -> str:
        """`robot_1-2`."""
        return self.spec.name

    @property
    def host_name(self) -> str:
        """Empty for this machine."""
        return "" if self.host is None else self.host.name

    @property
    def command_line(self) -> str:
        """As `spec.command_line`; on another host, without paths of this machine."""
        return " ".join(self.words_there) or self.spec.command_line

    @property
    def is_awaited(self) -> bool:
        """Whether the end of the run waits for its exit."""
        if self.host is not None:  # one that waits for its restart may be started meanwhile
            return self.machine.is_pending and not self.is_abandoned
        return self.machine.state.is_alive

    def adopt(self, spec: ProcessSpec) -> None:
        """From its next start on it has this spec; policies apply at once."""
        self.spec = spec
        self.machine.apply(spec.restart, spec.stop)

    @property
    def is_debugged(self) -> bool:
        """Whether it is, or is being started, under a debugger of a user."""
        return self.debugger is not None or self.next_debugger is not None

    def take_spec(self) -> ProcessSpec:
        """What its start, which is due, has to run: the next debugger counts as used then."""
        self.debugger, self.next_debugger = self.next_debugger, None
        return self.spec if self.debugger is None else self.debugger.spec

    def abandon(self, now: float) -> None:
        """The run ends without it."""
        self.is_abandoned = True
        if self.child is not None and self.machine.running_since is not None:
            self.history.run_s += now - self.machine.running_since

    @property
    def is_halted(self) -> bool:
        """Whether it exists and is suspended; on another host, as far as is known here."""
        if self.child is not None and self.host is None:
            self.saw_state(is_suspended=proc.is_suspended(self.child.pid))
        return self.was_halted

    @property
    def was_halted(self) -> bool:
        """The same as of the last look at its state in /proc, and without another one."""
        if self.child is None or self.host is not None:
            return self.child is not None and self.machine.is_suspended
        return self._halted_pid == self.child.pid

    def saw_state(self, *, is_suspended: bool) -> None:
        """Its child has this state in /proc now."""
        self._halted_pid = self.child.pid if is_suspended and self.child is not None else None

    def unfinished(self) -> list[Block]:
        """What it has written after its last line, such as a question, as lines."""
        return [
            Block(stream.name, stream.read_at_s, stream.buffer.partial + b"\n")
            for stream in self.streams.values()
            if stream.buffer.partial
        ]

    def last_lines(self, most: int) -> list[str]:
        """The last lines of its output, as a terminal would show them, the longest ones cut."""
        blocks = (Block(b.stream, b.read_at_s, for_terminal(b.lines)) for b in self.ring.last(most))
        return [text[:LAST_BYTES] for block in blocks for text in texts_of(block)]

    def shows(self, stream: str) -> bool:
        policy = self.spec.output
        return Sink.SCREEN in (policy.stderr if stream == "stderr" else policy.stdout)

    @property
    def streams_can_merge(self) -> bool:
        """Whether both streams go to the same places, so that one descriptor may carry both."""
        policy = self.spec.output
        return policy.stdout == policy.stderr and Sink.OWN_LOG not in policy.stdout


def adapted(spec: ProcessSpec, options: RunOptions) -> ProcessSpec:
    """What the options of the run make of it."""
    return with_printable_name(options.adapt(spec))


def with_printable_name(spec: ProcessSpec) -> ProcessSpec:
    """The spec with a name without control characters."""
    name = escape(spec.name, keep="")
    return spec if name == spec.name else replace(spec, name=name)


def child_environment(
    spec: ProcessSpec,
    before: Mapping[str, str],
    *,
    run_id_entry: tuple[str, str],
    log_dir: str | None,
    colour: bool,
) -> dict[str, str]:
    """The environment of a process: defaults, overridden by its spec, and the run id.

    By default Python flushes each line also to a pipe, rcutils colours its output if ours is
    coloured, and the node's own logs go to the folder of the run. There are no defaults if the
    launch file replaces the whole environment, which was that of `before`.
    """
    if replaces(spec.env, before):
        return {**spec.env, run_id_entry[0]: run_id_entry[1]}
    env = {
        "PYTHONUNBUFFERED": "1",
        "RCUTILS_COLORIZED_OUTPUT": "1" if colour else "0",
        **spec.env,
        run_id_entry[0]: run_id_entry[1],
    }
    if log_dir is not None and _is_in(env.get("ROS_LOG_DIR"), log_dir):
        env["ROS_LOG_DIR"] = log_dir
    return env


def _is_in(root: str | None, log_dir: str) -> bool:
    """Whether the run's folder is in `root`: then the process has inherited that value."""
    return not root or os.path.abspath(os.path.expanduser(root)) == os.path.dirname(log_dir)
