"""A host of a run, and a process on it, as the launcher sees them."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator

from launcher.base.model.run_events import Sample
from launcher.base.text import count
from launcher.hosts.engine.link import Link, LinkState
from launcher.hosts.file.hosts_model import Host
from launcher.posix.spawn import Child
from launcher.run.processes.process import Process

_GRACE_S = 3.0  # beyond the stop policies, for a host that cannot be reached


class RemoteHost:
    """`state` is what the link has reported; it may lag behind the link's own.

    `events`, `lines` and `dropped` count what was caught up since the link was lost. `samples` are
    the last ones, by name of process.
    """

    def __init__(self, host: Host) -> None:
        self.host = host
        self.name = host.name
        self.link: Link
        self.state = LinkState.CONNECTING
        self.processes: list[Process] = []
        self.is_abandoned = False
        self.lost_at_s = 0.0
        self.events = self.lines = self.dropped = 0
        self.samples: dict[str, Sample] = {}

    @property
    def unreachable_s(self) -> float | None:
        """How long it has been silent; None if it can be reached, or is gone."""
        return self.link.silent_s if self.state is LinkState.UNREACHABLE else None

    @property
    def is_gone(self) -> bool:
        return self.state is LinkState.GONE

    @property
    def pending(self) -> list[Process]:
        """Its processes that run or will be restarted, as far as is known."""
        return [one for one in self.processes if one.machine.is_pending]

    @property
    def longest_stop_s(self) -> float:
        """How long the end of the run waits for it while it cannot be reached."""
        graces = [process.machine.stop.grace_s for process in self.pending]
        return max(graces, default=0.0) + _GRACE_S

    @property
    def place(self) -> str:
        """`bot1 (robot@10.0.0.2)`."""
        user = f"{self.host.user}@" if self.host.user else ""
        return f"{self.name} ({user}{self.host.address})"

    def current_samples(self) -> Iterator[tuple[str, Sample]]:
        """The samples of processes that still run, by name."""
        for process in self.processes:
            sample, child = self.samples.get(process.name), process.child
            if sample is not None and child is not None and sample.pid == child.pid:
                yield process.name, sample

    def lost(self, now: float) -> None:
        """The link has reported that the host cannot be reached."""
        self.lost_at_s = now - self.link.silent_s
        self.events = self.lines = self.dropped = 0
        self.samples = {}

    def policy(self) -> str:
        """Whether its processes are stopped without the link: `its processes run on`."""
        stop_after_s = self.link.stop_after_s
        if stop_after_s is None:
            return "its processes run on"
        return f"its processes are stopped there after {stop_after_s:g} s"

    def caught_up(self) -> str:
        """`caught up with 3 events and 120 lines; 40 lines are lost`."""
        lost = f"; about {count(self.dropped, 'line')} of output lost" if self.dropped else ""
        text = f"caught up with {count(self.events, 'event')} and {count(self.lines, 'line')}"
        return text + lost


class RemoteChild(Child):
    """A running process on another host: it has a pid there, and no descriptors here."""

    def __init__(self, pid: int, process_id: int, host: RemoteHost) -> None:
        super().__init__(pid, {}, -1, -1, -1)
        self._process_id = process_id
        self._host = host

    def signal_group(self, signum: int) -> None:
        """Nothing: the host sends the signals."""

    def write_stdin(self, data: bytes) -> int:
        """All of it is sent; if the process does not read, the host warns of it."""
        if self._host.unreachable_s is not None:
            raise OSError(errno.EHOSTUNREACH, os.strerror(errno.EHOSTUNREACH))
        self._host.link.write_stdin(self._process_id, data)
        return len(data)


def host_of(process: Process) -> RemoteHost:
    """The host on which a process runs that does not run here."""
    assert isinstance(process.host, RemoteHost)
    return process.host
