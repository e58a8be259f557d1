"""The interface between a run and the engine of another host."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from launcher.engine.machine import Command, MachineEvent
    from launcher.hosts.order import Order


class LinkState(enum.Enum):
    """Whether the host can be reached.

    GONE: its engine has ended or was killed, and with it the processes; nothing more will come.
    """

    CONNECTING = "connecting"
    READY = "ready"
    UNREACHABLE = "unreachable"
    GONE = "gone"


class Link(Protocol):
    """One for each host of a run.

    The host decides: it feeds the state machine of a process with events and carries out its
    actions. The link reports each of these events to `LinkListener.event`, in order and once, and
    the operator feeds them to a state machine of its own, a replica, for messages and states.
    Requests are queued while the host cannot be reached, except those of `finish(at_once=True)`.
    """

    @property
    def state(self) -> LinkState: ...

    # Seconds since the host was heard of last.
    @property
    def silent_s(self) -> float: ...

    # Connect; the listener hears of the outcome.
    def open(self) -> None: ...

    # The order comes before the first command, and is kept for restarts.
    def prepare(self, process_id: int, order: Order) -> None: ...
    def command(self, process_id: int, command: Command) -> None: ...
    def signal(self, process_id: int, signum: int, *, by_user: bool) -> None: ...
    def write_stdin(self, process_id: int, data: bytes) -> None: ...

    # The screen is slow: the host stops reading output, or goes on.
    def pause(self, paused: bool) -> None: ...

    # The run has ended: stop what is left there, then report `finished`. `at_once` gives up on
    # a host that cannot be reached.
    def finish(self, *, at_once: bool) -> None: ...

    # Let everything there run on, and leave. OSError if the engine cannot.
    def detach(self) -> None: ...

    # Release descriptors and end helper processes here; idempotent.
    def close(self) -> None: ...


class LinkListener(Protocol):
    """The side of the run. All times are on the operator's monotonic clock, in seconds."""

    # The state machine of the process has handled this at that time; `pid` on STARTED.
    def event(self, process_id: int, event: MachineEvent, at_s: float, pid: int) -> None: ...

    # `stream` is `stdout`, `stderr` or `both`; what ends without a newline may continue.
    def output(self, process_id: int, stream: str, data: bytes, at_s: float) -> None: ...

    # Resources of processes: fields of `engine.monitor.resources.Sample` by process id.
    def samples(self, host: str, samples: Mapping[int, Mapping[str, Any]]) -> None: ...

    def link_changed(self, host: str, state: LinkState, reason: str) -> None: ...

    # A message of the host's engine for the user.
    def warn(self, host: str, text: str) -> None: ...

    # After `finish`: descriptions of leftovers that were stopped, and whether all went well.
    def finished(self, host: str, leftovers: Sequence[str], *, killed: bool) -> None: ...
