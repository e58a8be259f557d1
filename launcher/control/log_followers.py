"""The verb `logs`: the last lines of processes, and new lines for clients that follow."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import partial

from launcher.base.model.record import Record
from launcher.control.peer import Exchange
from launcher.output.lines import Block, LogRing, for_terminal, texts_of
from launcher.run.processes.process import Process
from launcher.run.run import Run

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    Item = dict[str, Any]


REPORT_S = 0.5  # between two reports of lines that were left out
ANSWER_BYTES = 1024 * 1024  # of lines in one answer: it is made in one pass of the loop


class Follower(Record):
    """A client that follows `chosen` process ids; None: all processes and the launcher."""

    exchange: Exchange
    chosen: frozenset[int] | None
    allowance: LineAllowance | None


class Logs:
    """Reads the ring buffers of processes; subscribes to them only while a client follows."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._followers: list[Follower] = []

    def last(self, processes: Sequence[Process] | None, most: int) -> list[Item]:
        """The last lines in order of time; None: of all processes and the launcher."""
        found: list[tuple[str | None, Block]] = []
        if processes is None:
            processes = self._run.processes
            found += [(None, block) for block in self._run.log.ring.last(most)]
        for process in processes:
            blocks = [*process.ring.last(most), *process.unfinished()]
            found += [(process.name, block) for block in blocks]
        found.sort(key=lambda one: one[1].read_at_s)
        items: list[Item] = []
        size = 0
        for name, block in reversed(found):
            if len(items) >= most or size > ANSWER_BYTES:
                break
            items += reversed(list(self._items(name, block)))
            size += len(block.lines)
        return items[:most][::-1]

    def follow(
        self,
        processes: Sequence[Process] | None,
        exchange: Exchange,
        max_rate: int | None = None,
    ) -> None:
        """Send new lines until the exchange ends; at most about `max_rate` a second of each."""
        chosen = None if processes is None else frozenset(p.process_id for p in processes)
        allowance = None if max_rate is None else LineAllowance(max_rate)
        follower = Follower(exchange=exchange, chosen=chosen, allowance=allowance)
        self._followers.append(follower)

        def leave() -> None:
            self._followers = [one for one in self._followers if one is not follower]
            self.subscribe()

        exchange.on_end = leave
        if allowance is not None:
            exchange.before_last = partial(self._report, exchange, allowance)
        self.subscribe()

    def subscribe(self) -> None:
        """Subscribe to the rings that are followed, and to no others."""
        of_all = [one for one in self._followers if one.chosen is None]
        self._set_tap(self._run.log.ring, None, of_all)
        for process in self._run.processes:
            followers = [
                one
                for one in self._followers
                if one.chosen is None or process.process_id in one.chosen
            ]
            self._set_tap(process.ring, process.name, followers)

    def _set_tap(self, ring: LogRing, name: str | None, followers: list[Follower]) -> None:
        ring.tap = partial(self._send, name, followers) if followers else None

    def _send(self, name: str | None, followers: Sequence[Follower], block: Block) -> None:
        takers = [one for one in followers if self._may_send(name, one, block)]
        if not takers:
            return
        for item in self._items(name, block):
            for follower in takers:
                follower.exchange.item(item)

    def _may_send(self, name: str | None, follower: Follower, block: Block) -> bool:
        """Whether the rate allows it; what is left out is reported a little later."""
        allowance = follower.allowance
        if allowance is None:
            return True
        is_reporting = allowance.has_left_out
        reactor = self._run.reactor
        may = allowance.take(name or "", block.lines.count(b"\n"), reactor.now())
        if allowance.has_left_out and not is_reporting:
            reactor.call_later(REPORT_S, partial(self._report, follower.exchange, allowance))
        return may

    def _report(self, exchange: Exchange, allowance: LineAllowance) -> None:
        left_out = allowance.left_out()
        if not left_out:
            return
        lines = sum(left_out.values())
        item = {"dropped": lines, "processes": left_out, "wall_s": time.time()}
        exchange.item(item, stands_for=lines)

    def _items(self, name: str | None, block: Block) -> Iterable[Item]:
        wall_s = time.time() - (self._run.reactor.now() - block.read_at_s)
        stream = block.stream or None
        clean = Block(block.stream, block.read_at_s, for_terminal(block.lines))
        for text in texts_of(clean):
            yield {"process": name, "stream": stream, "wall_s": wall_s, "text": text}


# ---- what is left out of a flood

BURST_S = 4.0  # what a process may have saved up: the start of a program is seldom a flood
_DEBT_S = 1.0  # after a large block, the lines that follow are left out for so long


class LineAllowance:
    """A token bucket for each process: `rate` lines a second.

    Splitting a flood into lines is expensive. A block of lines is sent as long as anything is left,
    and may overdraw it. `has_left_out`: something was left out since the last report.
    """

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._left: dict[str, float] = defaultdict(lambda: rate * BURST_S)
        self._since: dict[str, float] = {}
        self._left_out: dict[str, int] = {}

    @property
    def has_left_out(self) -> bool:
        return bool(self._left_out)

    def take(self, process: str, lines: int, now_s: float) -> bool:
        """Whether this many lines of a process may be sent now; those that may not are counted."""
        left = self._left[process] + (now_s - self._since.get(process, now_s)) * self._rate
        self._since[process] = now_s
        self._left[process] = left = min(left, self._rate * BURST_S)
        if left <= 0:
            self._left_out[process] = self._left_out.get(process, 0) + lines
            return False
        self._left[process] = max(left - lines, -self._rate * _DEBT_S)
        return True

    def left_out(self) -> dict[str, int]:
        """Lines of each process that were left out since the last call."""
        found, self._left_out = self._left_out, {}
        return found
