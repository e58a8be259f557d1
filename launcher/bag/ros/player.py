"""`bag play`: publishes what bags have, at the times when it was received."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launcher.bag.bag_model import Extent, Message, Qos, Span, summed
from launcher.bag.quantity_texts import clock as clock_text
from launcher.bag.reader import Bag
from launcher.bag.ros import control_services
from launcher.bag.ros.control_services import ControlServices
from launcher.bag.ros.ending import ending
from launcher.bag.ros.keys_and_status import Keys, StatusLine
from launcher.bag.ros.publishers import Publishers
from launcher.bag.ros.read_ahead import ReadAhead, by_sending, merged
from launcher.bag.topic_selection import Selection
from launcher.base.errors import ExitCode, UsageError
from launcher.base.ros_errors import VerbError
from launcher.base.text import count
from launcher.posix.allocator import keep_freed_memory
from launcher.ros.verb import GraphAccess, observing, warn

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

JUMP_S = 5.0
RATE_FACTOR = 1.1
_LONGEST_SLEEP_S = 0.05  # from one look at the keys to the next
_SWITCH_S = 0.0005  # the thread that reads ahead must not hold up a message for 5 ms
_BAR_WIDTH = 30
MIN_RATE, MAX_RATE = 0.01, 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayOptions:
    """What `bag play` was asked for; offsets and durations are seconds of the bag.

    `sent`: in the order and at the times of publishing. `redraw_s` is the time from one drawing of
    the status to the next; None: it is not drawn.
    """

    selection: Selection
    overrides: Mapping[str, Qos]
    remap: Mapping[str, str]
    rate: float
    loop: bool
    start_offset_s: float
    duration_s: float | None
    until_ns: int | None
    delay_s: float
    clock_hz: float | None
    clock_topics: frozenset[str] | None
    start_paused: bool
    acked_s: float
    requests: str | None
    goals: str | None
    read_ahead: int
    keyboard: bool
    sent: bool
    redraw_s: float | None


def play(access: GraphAccess, bags: Sequence[Bag], options: PlayOptions) -> int:
    """Play until the end, or Ctrl-C; the exit code. BagError, VerbError if nothing is played."""
    keep_freed_memory()
    with ending(interrupts=True):
        return _play(access, bags, options)


def _play(access: GraphAccess, bags: Sequence[Bag], options: PlayOptions) -> int:
    switch_s = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH_S)
    player, code = None, int(ExitCode.OK)
    try:
        with observing(access) as observer:
            status = StatusLine(
                lambda width: player.line(width) if player else "", options.redraw_s
            )
            publishers = Publishers(
                observer,
                options.overrides,
                options.remap,
                status.print,
                requests=options.requests,
                goals=options.goals,
            )
            topics = _added(bags, options.selection, publishers)
            player = _Player(bags, topics, options, publishers, status)
            player.offer_services(observer)
            graph = observer.prefetched_graph()
            publishers.warn_of_others(graph or observer.graph_snapshot())
            publishers.wait_for_others(graph, access.spin_time_s)
            player.run()
            code = player.exit_code
    except KeyboardInterrupt:
        pass
    finally:
        sys.setswitchinterval(switch_s)
    if player is not None:
        player.report()
    return code


def _added(
    bags: Sequence[Bag], selection: Selection, publishers: Publishers
) -> list[frozenset[str]]:
    """The topics of each bag that are played. VerbError if there are none."""
    played = [
        frozenset(
            topic.name
            for topic in bag.topics
            if selection.has(topic.name, topic.type) and publishers.add(topic)
        )
        for bag in bags
    ]
    if not any(played):
        known = sorted({topic.name for bag in bags for topic in bag.topics})
        raise VerbError(
            "no topic of the bag is played",
            hint=f"it has {', '.join(known[:10])}" if known else "it is empty",
        )
    return played


class _Player:
    """One playing; `run` returns at the end."""

    def __init__(
        self,
        bags: Sequence[Bag],
        topics: Sequence[frozenset[str]],
        options: PlayOptions,
        publishers: Publishers,
        status: StatusLine,
    ) -> None:
        self._bags = bags
        self._topics = topics
        self._options = options
        self._publishers = publishers
        self._status = status
        self._count = 0
        whole = summed(bag.extent for bag in bags)
        if options.sent:
            whole = self._sent(whole)
        self._first_ns = whole.start_ns + round(options.start_offset_s * 1e9)
        self._end_ns = self._last(whole)
        self._source = self._read_from(self._first_ns)
        self._clock = PlayClock(self._first_ns, 0.0, rate=options.rate)
        self._clock.paused = True  # until it runs
        self._has_begun = False
        self._next_clock_s = 0.0
        self._services: ControlServices | None = None
        self._is_stopped = False
        if self._has_clock:
            publishers.add_clock()

    def offer_services(self, observer: Observer) -> None:
        """Those of rosbag2, if their types are installed."""
        from launcher.bag.ros import player_services

        if control_services.are_installed():
            node = observer.companion(player_services.NODE)
            self._services = player_services.PlayerServices(node, self)

    @property
    def _has_clock(self) -> bool:
        return self._options.clock_hz is not None or self._options.clock_topics is not None

    def _sent(self, whole: Extent) -> Extent:
        """The times of publishing, as far as the first messages show them."""
        read_ahead = self._options.read_ahead
        first = next(by_sending(merged(self._bags, self._topics, Span()), read_ahead), None)
        shift_ns = 0 if first is None else first.log_ns - whole.start_ns
        return Extent(whole.counts, whole.start_ns + shift_ns, whole.end_ns + shift_ns)

    def _last(self, whole: Extent) -> int:
        """The time of the last message that may be played."""
        ends = [whole.end_ns]
        if self._options.duration_s is not None:
            ends.append(self._first_ns + round(self._options.duration_s * 1e9))
        if self._options.until_ns is not None:
            ends.append(self._options.until_ns)
        return min(ends)

    def _read_from(self, start_ns: int) -> ReadAhead:
        options = self._options
        end_ns: int | None = max(start_ns, self._end_ns + 1)
        if options.sent and options.duration_s is None and options.until_ns is None:
            end_ns = None  # the time of the last one is not known
        span = Span(start_ns, end_ns)
        return ReadAhead(self._bags, self._topics, span, options.read_ahead, sent=options.sent)

    def run(self) -> None:
        try:
            with Keys(enabled=self._options.keyboard) as keys:
                self._require_messages()
                self._greet(keys.enabled)
                self._has_begun = True
                now = time.monotonic()
                self._clock.jump(self._first_ns, now + self._options.delay_s)
                self._clock.set_paused(self._options.start_paused, now + self._options.delay_s)
                while self._play_once(keys) and self._options.loop and not self._is_stopped:
                    self.seek(self._first_ns)
            self._status.close()
            limit_s = self._options.acked_s
            if not self._publishers.wait_for_all_acked(limit_s):
                warn(f"not everything was received after {limit_s:g} s")
        finally:
            self._status.close()
            self._source.close()

    def _require_messages(self) -> None:
        """UsageError if the start is behind the end, in the order of publishing."""
        offset_s = self._options.start_offset_s
        if not self._options.sent or not offset_s or self._source.peek() is not None:
            return
        times = [one.publish_ns or one.log_ns for one in merged(self._bags, self._topics, Span())]
        if times and max(times) < self._first_ns:
            raise UsageError(behind_the_end((max(times) - self._first_ns) / 1e9 + offset_s))

    @property
    def exit_code(self) -> int:
        """After the end: 1 if requests were to be sent, and none was."""
        return ExitCode.PROCESS_FAILED if self._publishers.sent == 0 else ExitCode.OK

    def _greet(self, has_keys: bool) -> None:
        names = {name for topics in self._topics for name in topics}
        keys = " (space pauses, left and right jump, up and down change the rate)"
        self._status.print(f"playing {count(len(names), 'topic')}{keys if has_keys else ''}")

    def _play_once(self, keys: Keys) -> bool:
        """Play to the end; whether there was a message."""
        found = False
        while not self._is_stopped and (message := self._source.peek()) is not None:
            now = time.monotonic()
            wait_s = self._clock.wait_s(message.log_ns, now)
            if wait_s <= 0:
                self._source.pop()
                self._publish(message)
                found = True
            if wait_s > 0 or self._status.enabled:
                self._handle(keys)
            if self._services is not None:
                self._services.poll()
            if self._options.clock_hz is not None:
                wait_s = min(wait_s, self._tick_clock())
            self._status.draw()
            if wait_s > 0:
                self._publishers.poll()
                time.sleep(min(wait_s, _LONGEST_SLEEP_S))
        return found

    def _publish(self, message: Message) -> None:
        topics = self._options.clock_topics
        if topics is not None and (not topics or message.topic in topics):
            self._publishers.publish_clock(message.log_ns)
        self._count += self._publishers.publish(message)

    def _tick_clock(self) -> float:
        """Publish `/clock` if it is time; how long until the next time."""
        assert self._options.clock_hz is not None
        now, period_s = time.monotonic(), 1.0 / self._options.clock_hz
        if now >= self._next_clock_s:
            self._publishers.publish_clock(self._clock.time_ns(now))
            self._next_clock_s = max(self._next_clock_s + period_s, now)
        return self._next_clock_s - now

    def _handle(self, keys: Keys) -> None:
        for key in keys.pressed():
            now = time.monotonic()
            if key == " ":
                self.paused = not self.paused
            elif key in ("up", "down"):
                self.rate *= RATE_FACTOR if key == "up" else 1 / RATE_FACTOR
            elif key == "right" and self.paused:
                self.step(1)
            elif key in ("left", "right"):
                step_ns = round(JUMP_S * 1e9) * (1 if key == "right" else -1)
                self.seek(self._clock.time_ns(now) + step_ns)
            self._status.draw(now=True)

    @property
    def paused(self) -> bool:
        return self._clock.paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._clock.set_paused(paused, time.monotonic())

    @property
    def rate(self) -> float:
        return self._clock.rate

    @rate.setter
    def rate(self, rate: float) -> None:
        self._clock.set_rate(rate, time.monotonic())

    def step(self, number: int) -> int:
        """The next messages at once, 0: all, while paused; how many there were."""
        found = 0
        while self.paused and (not number or found < number):
            message = self._source.peek()
            if message is None:
                break
            self._source.pop()
            self._publish(message)
            self._clock.jump(message.log_ns, time.monotonic())
            found += 1
        return found

    def seek(self, bag_ns: int) -> None:
        bag_ns = min(max(bag_ns, self._first_ns), self._end_ns)
        self._source.close()
        self._source = self._read_from(bag_ns)
        self._clock.jump(bag_ns, time.monotonic())

    def stop(self) -> None:
        self._is_stopped = True

    def line(self, width: int) -> str:
        """The status: a bar of how much was played."""
        played_s = max(0, self._clock.time_ns(time.monotonic()) - self._first_ns) / 1e9
        whole_s = max(0, self._end_ns - self._first_ns) / 1e9
        part = min(1.0, played_s / whole_s) if whole_s else 1.0
        filled = round(part * _BAR_WIDTH)
        bar = "[" + "=" * filled + " " * (_BAR_WIDTH - filled) + "]"
        state = "paused " if self._clock.paused else "playing"
        state = state if self._has_begun else "waiting"
        sent = "" if self._publishers.sent is None else f"  {self._publishers.sent} requests"
        return (
            f"{state} {bar} {clock_text(min(played_s, whole_s))} of {clock_text(whole_s)}  "
            f"x{self._clock.rate:.2f}  {self._count} messages{sent}"
        )

    def report(self) -> None:
        sent, done = self._publishers.sent, []
        if self._count or sent is None:
            done.append(f"played {count(self._count, 'message')}")
        if sent is not None:
            done.append(f"sent {count(sent, 'request')}")
        self._status.print(", ".join(done))
        if sent == 0:
            why = self._publishers.why_nothing_was_sent()
            self._status.print(f"warning: no request was sent: {why}")


def behind_the_end(whole_s: float) -> str:
    return f"--start-offset is behind the end: the bag has {whole_s:.3f} s"


class PlayClock:
    """Bag time (ns) as a function of a monotonic time (s): it runs at a rate, pauses and jumps."""

    def __init__(self, bag_ns: int, now_s: float, *, rate: float = 1.0) -> None:
        self.rate = rate
        self.paused = False
        self._bag_ns = bag_ns
        self._since_s = now_s

    def time_ns(self, now_s: float) -> int:
        if self.paused:
            return self._bag_ns
        return self._bag_ns + round((now_s - self._since_s) * self.rate * 1e9)

    def wait_s(self, bag_ns: int, now_s: float) -> float:
        """How long until this time of the bag; infinite while paused, negative in the past."""
        if self.paused:
            return float("inf")
        return (bag_ns - self.time_ns(now_s)) / 1e9 / self.rate

    def jump(self, bag_ns: int, now_s: float) -> None:
        self._bag_ns, self._since_s = bag_ns, now_s

    def set_rate(self, rate: float, now_s: float) -> None:
        self.jump(self.time_ns(now_s), now_s)
        self.rate = min(max(rate, MIN_RATE), MAX_RATE)

    def set_paused(self, paused: bool, now_s: float) -> None:
        self.jump(self.time_ns(now_s), now_s)
        self.paused = paused
