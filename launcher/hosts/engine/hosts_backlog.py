"""The last lines of a run that is attached to."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from launcher.posix.reactor import Reactor, Timer

# process id, stream, data, time
Output = tuple[int, str, bytes, float]


WAIT_S = 3.0  # for slow hosts


class HostsBacklog:
    """Holds past output until that of all hosts has come; then `show` gets the last `lines` of the
    run, in order of time, and all that is new.

    A host that is slow is not waited for: its last lines follow when they have come.
    """

    def __init__(
        self,
        lines: int,
        hosts: Iterable[str],
        reactor: Reactor,
        show: Callable[[int, str, bytes, float], None],
    ) -> None:
        self._lines = lines
        self._reactor = reactor
        self._show = show
        self._awaited: dict[str, list[Output]] = {host: [] for host in hosts}
        self._past: list[Output] = []  # of hosts whose past output is complete
        self._new: list[Output] = []
        self._waits = bool(self._awaited)
        self._timer: Timer | None = None

    def add(self, host: str, output: Output) -> None:
        """What a process there has written."""
        if host in self._awaited:
            self._awaited[host].append(output)
        elif self._waits:
            self._new.append(output)
        else:
            self._show(*output)
        if self._waits and self._timer is None:
            self._timer = self._reactor.call_later(WAIT_S, self.flush)

    def complete(self, host: str) -> None:
        """What comes from there now is new, or nothing comes any more; idempotent."""
        self._past += self._awaited.pop(host, ())
        if not (self._waits and self._awaited):
            self.flush()

    def flush(self) -> None:
        """Wait for no other host: show the past output of those whose output is complete."""
        self._waits = False
        if self._timer is not None:
            self._timer.cancel()
        past, self._past = self._past, []
        new, self._new = self._new, []
        for one in (*last_lines(past, self._lines), *new):
            self._show(*one)

    def close(self) -> None:
        """Show all that is held; idempotent."""
        for host in list(self._awaited):
            self._past += self._awaited.pop(host)
        self.flush()


def last_lines(held: Iterable[Output], most: int) -> list[Output]:
    """The last lines of all, in order of time; a long line may be in pieces."""
    ordered = sorted(held, key=lambda one: one[3])
    kept: list[Output] = []
    is_kept: dict[tuple[int, str], bool] = {}  # the line of each stream whose end was seen last
    for process_id, stream, data, at_s in reversed(ordered):
        key = process_id, stream
        if data.endswith(b"\n") or key not in is_kept:
            is_kept[key] = most > 0
            most -= 1
        if is_kept[key]:
            kept.append((process_id, stream, data, at_s))
    return kept[::-1]
