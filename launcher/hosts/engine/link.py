"""The interface between a run and the engine of another host."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Protocol

from launcher.base.model.record import Record

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from launcher.hosts.file.hosts_model import Host
    from launcher.hosts.file.order import Order
    from launcher.posix.reactor import Reactor
    from launcher.run.processes.machine_events import MachineCommand, MachineEvent, ProcessState


BEAT_S = 1.0
_BEATS = 4  # in the time after which a host without the operator stops its processes


def beat_s(stop_after_s: float | None) -> float:
    """How often a host gets a sign of the operator: well before it would stop its processes."""
    return BEAT_S if stop_after_s is None else min(BEAT_S, stop_after_s / _BEATS)


class LinkState(enum.Enum):
    """Whether the host can be reached.

    GONE: it refuses, or its engine has ended or was killed, and with it the processes; nothing
    more will come.
    """

    CONNECTING = "connecting"
    READY = "ready"
    UNREACHABLE = "unreachable"
    GONE = "gone"


class Link(Protocol):
    """One for each host of a run.

    The host decides: it feeds the state machine of a process with events and carries out its
    actions. The link reports each of these events to `LinkListener.event`, in order and once, and
    the operator feeds them to a replica of the machine, for messages and states.
    Requests are queued while the host cannot be reached, except those of `finish(at_once=True)`.
    """

    @property
    def state(self) -> LinkState: ...

    # Seconds since anything came from the host.
    @property
    def silent_s(self) -> float: ...

    # After so many seconds without the operator the host stops its processes; None: never.
    @property
    def stop_after_s(self) -> float | None: ...

    # Connect, and report READY, or UNREACHABLE or GONE with a reason that says what to do. Only
    # after READY it goes on trying by itself.
    def open(self) -> None: ...

    # The name of its unit of systemd there; empty without one.
    def unit(self, process_id: int) -> str: ...

    # The order comes before the first command, and is kept for restarts.
    def prepare(self, process_id: int, order: Order) -> None: ...
    def command(self, process_id: int, command: MachineCommand) -> None: ...
    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None: ...
    def write_stdin(self, process_id: int, data: bytes) -> None: ...

    # The screen is slow: the host stops reading output, or goes on.
    def pause(self, paused: bool) -> None: ...

    # The run has ended: stop what is left there, then report `finished`. `at_once` skips grace
    # periods, and does not wait for a host that cannot be reached; it may follow the other one.
    def finish(self, *, at_once: bool) -> None: ...

    # Let everything there run on; the run ends without `finish`. OSError says why it cannot. It
    # changes nothing there: all hosts are asked, and if one cannot, none is left.
    def detach(self) -> None: ...

    # Release descriptors and end helper processes here; idempotent.
    def close(self) -> None: ...


class LinkListener(Protocol):
    """The side of the run. All times are on the operator's monotonic clock, in seconds.

    Those of events are converted with an offset that stays the same as long as the processes
    live, so that the replica sees the same differences as the host. No call may come from within
    a call of a method of the link.
    """

    # The state machine of the process has handled this at that time, and its deadline is `left_s`
    # later (None: it has none); `pid` on STARTED. Commands and signals of the operator are
    # reported even if they had no effect, a TICK only if it was due. What a process has written
    # comes before its exit.
    def event(
        self, process_id: int, event: MachineEvent, at_s: float, pid: int, left_s: float | None
    ) -> None: ...

    # `stream` is `stdout`, `stderr` or `both`; what ends without a newline may continue. Without
    # data: the process has been silent since, so what is not finished may be shown.
    def output(self, process_id: int, stream: str, data: bytes, at_s: float) -> None: ...

    # The host has lost about so many lines of output, since it could not be reached for too long.
    def dropped(self, host: str, lines: int) -> None: ...

    # Resources of processes: fields of `engine.monitor.resources.Sample` by process id.
    def samples(self, host: str, samples: Mapping[int, Mapping[str, Any]]) -> None: ...

    # READY after UNREACHABLE is reported when everything that was missed has been.
    def link_changed(self, host: str, state: LinkState, reason: str) -> None: ...

    # A run that is attached to: its process was in this state when the link was made (`pid` -1:
    # it did not run), and has been since `since_s`. Comes instead of the events of its START.
    def adopted(
        self, process_id: int, state: ProcessState, pid: int, since_s: float, restarts: int
    ) -> None: ...

    # A run that is attached to: its last lines have come, and what comes now is new.
    def past_complete(self, host: str) -> None: ...

    # An operator ends the run there; it may have been this one.
    def run_ended(self, host: str, operator: str) -> None: ...

    # A message of the host's engine for the user.
    def warn(self, host: str, text: str) -> None: ...

    # After `finish`: descriptions of leftovers that were stopped, and whether one was killed.
    def finished(self, host: str, leftovers: Sequence[str], *, killed: bool) -> None: ...


class Attached(Record):
    """A run that goes on: its id on the hosts, and how many of its last lines are shown."""

    run: str
    lines: int = 10


class LinkContext(Record):
    """What a link needs of its run; `environment` is that of the launcher.

    `title` says for users what was launched. `attached`: the processes run already.
    """

    host: Host
    listener: LinkListener
    reactor: Reactor
    run_id: str
    environment: Mapping[str, str]
    title: str = ""
    attached: Attached | None = None
