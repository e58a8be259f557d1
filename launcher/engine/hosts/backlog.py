"""The last lines of a run that is attached to."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from launcher.engine.posix.reactor import Reactor, Timer

    # process id, stream, data, time
    Output = tuple[int, str, bytes, float]

WAIT_S = 3.0  # for hosts that are slow to tell theirs


class Backlog:
    """Holds the output until all hosts have told their last lines; then `show` gets the last
    `lines` of the run, in order of time.
    """

    def __init__(
        self,
        lines: int,
        hosts: Iterable[str],
        reactor: Reactor,
        show: Callable[[int, str, bytes, float], None],
    ) -> None:
        self._lines = lines
        self._awaited = set(hosts)
        self._reactor = reactor
        self._show = show
        self._held: list[Output] = []
        self._timer: Timer | None = None
        self.is_open = True

    def add(self, process_id: int, stream: str, data: bytes, at_s: float) -> None:
        self._held.append((process_id, stream, data, at_s))
        self._set_timer()

    def told(self, host: str) -> None:
        """It has told its last lines, or cannot."""
        self._awaited.discard(host)
        if not self._awaited:
            self.close()
        else:
            self._set_timer()

    def _set_timer(self) -> None:
        if self.is_open and self._timer is None:
            self._timer = self._reactor.call_later(WAIT_S, self.close)

    def close(self) -> None:
        """Show what there is; idempotent."""
        self.is_open = False
        if self._timer is not None:
            self._timer.cancel()
        held, self._held = self._held, []
        for one in last_lines(held, self._lines):
            self._show(*one)


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
