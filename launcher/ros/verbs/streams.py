"""`topic echo`, `hz`, `bw` and `delay`: listen until enough has arrived, or Ctrl-C."""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError
from launcher.posix.json_output import json_line, print_line
from launcher.ros.topics import statistics
from launcher.ros.topics.clock import WallClock, clock_of
from launcher.ros.topics.echo import Writer, compiled_filter
from launcher.ros.topics.listener import Listener, ReceivedMessage, TopicTarget
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import GraphAccess, observing, warn
from launcher.ros.verbs.awaited_topics import AwaitedTopics, TopicSubscriber, are_published

SILENCE_S = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class EchoOptions:
    """What `topic echo` was asked for; `type` is for topics that do not exist yet."""

    access: GraphAccess
    topics: list[str]
    type: str | None
    writer: Writer
    qos: QosOptions
    filter: str | None
    once: bool
    timeout_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureOptions:
    """What `topic hz`, `bw` or `delay` was asked for; `window` is a number of messages."""

    access: GraphAccess
    topics: list[str]
    qos: QosOptions
    window: int
    for_s: float | None
    use_sim_time: bool
    json: bool
    filter: str | None = None
    min_hz: float | None = None


@contextlib.contextmanager
def until_interrupted(*, is_end: bool = True) -> Iterator[None]:
    """Take a closed pipe for a normal end, and Ctrl-C where there `is_end` no other.

    What has a set end, such as `--once` or `--for`, is not done if it is interrupted.
    """
    try:
        yield
        sys.stdout.flush()
    except KeyboardInterrupt:
        sys.stdout.flush()
        if not is_end:
            raise
    except BrokenPipeError:
        # so that the interpreter's last flush does not fail again
        sys.stdout = open("/dev/null", "w")  # noqa: SIM115


def echo(options: EchoOptions) -> int:
    writer, accepts = options.writer, compiled_filter(options.filter)
    enough = are_published(options.topics)
    is_endless, is_silent = not options.once and options.timeout_s is None, True
    with (
        until_interrupted(is_end=is_endless),
        observing(options.access, enough, listens=True) as observer,
    ):
        listener = Listener(observer, raw=writer.raw)
        subscriber = TopicSubscriber(observer, listener, options.qos, options.access.spin_time_s)
        for name in options.topics:
            subscriber.subscribe_now(name, options.type)
        limit = ListeningLimit(options.timeout_s)
        write = sys.stdout.write
        for sample in listener.samples(limit.tick):
            limit.is_fresh = True
            value = writer.value(sample)
            if accepts and not writer.raw and not accepts(value):
                continue
            is_silent = False
            for piece in writer.pieces(sample, value):
                write(piece)
            if options.once:
                break
    if is_silent and options.timeout_s is not None:
        return nothing_came(options.topics, options.timeout_s, options.filter)
    return ExitCode.OK


def nothing_came(names: Sequence[str], limit_s: float, accepted: str | None = None) -> int:
    """Say that no message has come in time, or none that a filter accepts; the exit code."""
    what = "no message" if accepted is None else "no message that fits --filter"
    warn(f"{what} on {', '.join(map(full_name, names))} within {limit_s:g} s")
    return ExitCode.PROCESS_FAILED


def _too_few(name: str, count: int, limit_s: float, accepted: str | None = None) -> int:
    """The same for a measurement, for which one message is too few."""
    if count == 0:
        return nothing_came([name], limit_s, accepted)
    warn(f"only one message on {full_name(name)} within {limit_s:g} s")
    return ExitCode.PROCESS_FAILED


class ListeningLimit:
    """Ends listening after `timeout_s`; flushes after each burst."""

    def __init__(self, timeout_s: float | None) -> None:
        self._end = math.inf if timeout_s is None else time.monotonic() + timeout_s
        self.is_fresh = False

    def tick(self) -> bool:
        if self.is_fresh:
            sys.stdout.flush()
            self.is_fresh = False
        return time.monotonic() < self._end


class _Clock:
    """Ends a measurement after `for_s`, calls `report` once a second, polls awaited topics."""

    def __init__(
        self, for_s: float | None, awaited: AwaitedTopics, report: Callable[[], None]
    ) -> None:
        self._awaited = awaited
        self._start = time.monotonic()
        self._end = None if for_s is None else self._start + for_s
        self._next = self._start + 1.0
        self._report = report

    def tick(self) -> bool:
        self._awaited.poll()
        now = time.monotonic()
        if now >= self._next:
            self._next += 1.0
            self._report()
            sys.stdout.flush()
        return self._end is None or now < self._end


class _Quiet:
    """Warns, once per silence, that a topic has become silent."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._last = time.monotonic()
        self._has_warned = False

    def message(self) -> None:
        self._last, self._has_warned = time.monotonic(), False

    def check(self) -> None:
        gap_s = time.monotonic() - self._last
        if gap_s >= SILENCE_S and not self._has_warned:
            self._has_warned = True
            warn(f"no message on {self._topic} for {gap_s:.1f} s")


def _measure(
    options: MeasureOptions,
    clock: WallClock,
    found: Callable[[TopicTarget], None],
    take: Callable[[ReceivedMessage, int], None],
    report: Callable[[], None],
    *,
    raw: bool,
) -> None:
    """Call `found` for each topic, `take` for each message, and `report` once a second.

    `take` gets the time of arrival by the clock, and no message before that is known.
    """
    with (
        until_interrupted(is_end=options.for_s is None),
        observing(options.access, are_published(options.topics), listens=True) as observer,
    ):
        clock.start(observer)
        listener = Listener(observer, raw=raw)
        subscriber = TopicSubscriber(observer, listener, options.qos, options.access.spin_time_s)
        awaited = AwaitedTopics(subscriber, options.topics, found)
        for sample in listener.samples(_Clock(options.for_s, awaited, report).tick):
            received_ns = clock.received_ns(sample)
            if received_ns is not None:
                take(sample, received_ns)
        clock.stop()


def hz(options: MeasureOptions) -> int:
    """Print rates; exit code 1 if there is none at the end, or one below `--min`."""
    accepts = compiled_filter(options.filter)
    names = list(map(full_name, options.topics))
    arrivals = {name: statistics.Arrivals(options.window) for name in names}
    quiet: dict[str, _Quiet] = {}
    clock = clock_of(simulated=options.use_sim_time)

    def found(target: TopicTarget) -> None:
        quiet[target.name] = _Quiet(target.name)

    def take(sample: ReceivedMessage, received_ns: int) -> None:
        if sample.is_history:
            return
        quiet[sample.topic].message()
        if accepts is None or accepts(sample.message):
            arrivals[sample.topic].add(received_ns)

    def report() -> None:
        due = {name: spread for name, a in arrivals.items() if (spread := a.due())}
        for one in quiet.values():
            one.check()
        _print_rates(due, arrivals, options)

    _measure(options, clock, found, take, report, raw=accepts is None)
    if options.for_s is None:
        return ExitCode.OK
    _print_rates(
        {n: spread for n, a in arrivals.items() if (spread := a.rest())}, arrivals, options
    )
    return _verdict(arrivals, options, clock.now_ns() or 0)


def _print_rates(
    found: dict[str, statistics.Spread],
    arrivals: dict[str, statistics.Arrivals],
    options: MeasureOptions,
) -> None:
    if not found:
        return
    if options.json:
        for name, one in found.items():
            print_line({"topic": name, "event": "rate", **_document(one, "rate_hz", "mean_hz")})
    elif len(arrivals) == 1:
        print(statistics.rate_text(next(iter(found.values()))))
    else:
        # all topics, so that the rows stay in their places
        print(
            statistics.rate_table({n: spread for n, a in arrivals.items() if (spread := a.now())})
        )


def _document(spread: statistics.Spread, mean: str, key: str) -> dict[str, Any]:
    spreads = {n: getattr(spread, n) for n in ("min_s", "max_s", "std_dev_s", "window")}
    return {key: getattr(spread, mean), **spreads}


def _verdict(arrivals: dict[str, statistics.Arrivals], options: MeasureOptions, now_ns: int) -> int:
    assert options.for_s is not None
    code = int(ExitCode.OK)
    for name, one in arrivals.items():
        mean_hz = one.mean_rate_hz(now_ns)
        if options.json:
            total = {"messages": one.count, "mean_hz": mean_hz}
            print_line({"topic": name, "event": "total", **total})
        if one.count < 2:
            code = _too_few(name, one.count, options.for_s, options.filter)
        elif not options.json and options.min_hz is not None and mean_hz < options.min_hz:
            warn(
                f"{name}: {mean_hz:.3f} Hz over {options.for_s:g} s, "
                f"below the minimum of {options.min_hz:g} Hz"
            )
        if options.min_hz is not None and mean_hz < options.min_hz:
            code = ExitCode.PROCESS_FAILED
    return code


def bw(options: MeasureOptions) -> int:
    topic, sizes = full_name(options.topics[0]), statistics.Bandwidth(options.window)

    def line(now_ns: int) -> str | None:
        due = sizes.due(now_ns)
        if due is None or not options.json:
            return due and statistics.bandwidth_text(*due)
        return json_line({"topic": topic, **_bandwidth_document(*due)})

    def found(target: TopicTarget) -> None:
        if not options.json:
            print(f"Subscribed to [{target.name}]", flush=True)

    def take(sample: ReceivedMessage, received_ns: int) -> None:
        if not sample.is_history:
            sizes.add(received_ns, len(sample.message))

    silent_s = _silent_s(options, found, take, line, raw=True)
    return ExitCode.OK if silent_s is None else _too_few(options.topics[0], len(sizes), silent_s)


def _silent_s(
    options: MeasureOptions,
    found: Callable[[TopicTarget], None],
    take: Callable[[ReceivedMessage, int], None],
    line: Callable[[int], str | None],
    *,
    raw: bool,
) -> float | None:
    """Measure one topic, a line each second; the time that is up, if there was no line."""
    is_silent, clock = True, clock_of(simulated=options.use_sim_time)

    def report() -> None:
        nonlocal is_silent
        if text := line(clock.now_ns() or 0):
            print(text)
            is_silent = False

    _measure(options, clock, found, take, report, raw=raw)
    if is_silent and options.for_s is not None:
        report()
    return options.for_s if is_silent else None


def _bandwidth_document(rate: float, sizes: list[int]) -> dict[str, Any]:
    least, most = min(sizes), max(sizes)
    return {"bytes_per_s": rate, "messages": len(sizes), "min_bytes": least, "max_bytes": most}


def delay(options: MeasureOptions) -> int:
    topic, delays = full_name(options.topics[0]), statistics.Delays(options.window)

    def line(now_ns: int) -> str | None:
        due = delays.due()
        if due is None:
            return None
        spread, fresh = due
        if not options.json:
            return statistics.delay_text(spread, fresh=fresh)
        document = _document(spread, "mean_s", "mean_s")
        return json_line({"topic": topic, **document, "fresh": fresh})

    def take(sample: ReceivedMessage, received_ns: int) -> None:
        delays.add(received_ns - _stamp_ns(sample.message))

    silent_s = _silent_s(options, lambda target: None, take, line, raw=False)
    return ExitCode.OK if silent_s is None else nothing_came(options.topics, silent_s)


def _stamp_ns(message: Any) -> int:
    try:
        stamp = message.header.stamp
    except AttributeError:
        raise VerbError(
            "msg does not have header", hint=f"{type(message).__name__} carries no time stamp"
        ) from None
    return int(stamp.sec) * statistics.NANOS + int(stamp.nanosec)
