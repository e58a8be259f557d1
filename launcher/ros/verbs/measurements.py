"""`topic hz`, `bw` and `delay`: measure topics until `--for` is over, or Ctrl-C."""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError
from launcher.base.text import count
from launcher.posix.domains import why_empty
from launcher.posix.json_output import print_line
from launcher.ros.discovery.completeness import settled_graph
from launcher.ros.snapshot.ros_graph import GraphSnapshot, is_hidden
from launcher.ros.topics import statistics
from launcher.ros.topics.clock import clock_of
from launcher.ros.topics.echo import compiled_filter
from launcher.ros.topics.listener import Listener, ReceivedMessage, TopicTarget
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import GraphAccess, clear_screen, observing, say, warn
from launcher.ros.verbs.awaited_topics import AwaitedTopics, TopicSubscriber, are_published
from launcher.ros.verbs.streams import nothing_came, until_interrupted

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

SILENCE_S = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureOptions:
    """What was asked for; `window` is a number of messages.

    Without `topics` all that there are, `hidden` ones if wanted.
    """

    access: GraphAccess
    topics: list[str]
    qos: QosOptions
    window: int
    for_s: float | None
    use_sim_time: bool
    json: bool
    hidden: bool = False
    filter: str | None = None
    min_hz: float | None = None


class Measurement:
    """What is measured of `topics`, by full names: what a verb does with messages.

    With `is_raw` messages are not decoded.
    """

    is_raw = True

    def __init__(self, options: MeasureOptions) -> None:
        self.options = options
        self.topics = list(dict.fromkeys(map(full_name, options.topics)))
        self.clock = clock_of(simulated=options.use_sim_time)

    # ---- of a verb

    def found(self, target: TopicTarget) -> None:
        """A topic is subscribed to."""

    def take(self, sample: ReceivedMessage, received_ns: int) -> None:
        """A message has arrived, at this time of the clock."""
        raise NotImplementedError

    def report(self) -> None:
        """Print what is new; called once a second."""
        raise NotImplementedError

    def rest(self) -> None:
        """Print at the end what was never printed."""
        self.report()

    def verdict(self, for_s: float) -> int:
        """The exit code at the end of `--for`."""
        raise NotImplementedError

    # ---- of all

    @property
    def is_alone(self) -> bool:
        return len(self.topics) == 1

    def run(self) -> int:
        options = self.options
        with (
            until_interrupted(is_end=options.for_s is None),
            observing(options.access, self._enough(), listens=True) as observer,
        ):
            self.clock.start(observer)
            if not options.topics:
                self._find_all(observer)
            self._listen(observer)
            self.clock.stop()
        if not self.topics:
            return ExitCode.PROCESS_FAILED
        if options.for_s is None:
            return ExitCode.OK
        self.rest()
        return self.verdict(options.for_s)

    def _enough(self) -> Callable[[GraphSnapshot], object]:
        names = self.options.topics
        return are_published(names) if names else lambda graph: False

    def _find_all(self, observer: Observer) -> None:
        graph = settled_graph(observer, self.options.access.spin_time_s, self._enough())
        names = sorted(graph.topic_types())
        self.topics = [name for name in names if self.options.hidden or not is_hidden(name)]
        found = f"Subscribing to all {len(self.topics)} available topics..."
        self.say(found if self.topics else "No topics available")
        if not graph.nodes:
            warn(f"hint: {why_empty(self.options.access.domain_id)}")

    def _listen(self, observer: Observer) -> None:
        options = self.options
        listener = Listener(observer, raw=self.is_raw)
        subscriber = TopicSubscriber(
            observer, listener, options.qos, options.access.spin_time_s, json=options.json
        )
        names = {full_name(name): name for name in options.topics or self.topics}
        awaited = AwaitedTopics(subscriber, list(names.values()), self.found, self._drop)
        for sample in listener.samples(_Clock(self, awaited).tick):
            received_ns = self.clock.received_ns(sample)
            if received_ns is not None:
                self.take(sample, received_ns)

    def _drop(self, name: str, error: VerbError) -> None:
        """Go on without a topic whose messages cannot be received."""
        self.say(f"WARNING: failed to find message type for topic [{name}]")
        warn(error.render())
        self.topics.remove(full_name(name))

    def say(self, text: str) -> None:
        say(text, json=self.options.json)

    def print_table(self, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        self.clear()
        print(statistics.table(head, rows))

    def clear(self) -> None:
        """Clear the screen before a report about all topics, as ros2cli does."""
        if not self.options.topics:
            clear_screen()

    def too_few(self, counts: Iterable[tuple[str, int]], for_s: float, least: int = 2) -> int:
        """Name the topics with too few messages; the exit code.

        Of all topics that there are, some may be silent, but not each.
        """
        few = [(name, number) for name, number in counts if number < least]
        if not self.options.topics:
            if len(few) < len(self.topics):
                return ExitCode.OK
            warn(f"nothing to measure on {count(len(few), 'topic')} within {for_s:g} s")
            return ExitCode.PROCESS_FAILED
        for name, number in few:
            if number == 0:
                nothing_came([name], for_s, self.options.filter)
            else:
                warn(f"only one message on {name} within {for_s:g} s")
        return ExitCode.PROCESS_FAILED if few else ExitCode.OK


class _Clock:
    """Ends a measurement after `--for`, reports once a second, polls awaited topics."""

    def __init__(self, measurement: Measurement, awaited: AwaitedTopics) -> None:
        self._measurement = measurement
        self._awaited = awaited
        for_s, start = measurement.options.for_s, time.monotonic()
        self._end = None if for_s is None else start + for_s
        self._next = start + 1.0

    def tick(self) -> bool:
        self._awaited.poll()
        now = time.monotonic()
        if now >= self._next:
            self._next += 1.0
            self._measurement.report()
            sys.stdout.flush()
        is_over = self._end is not None and now >= self._end
        return bool(self._measurement.topics) and not is_over


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


class Rates(Measurement):
    """`topic hz`: rates; exit code 1 if there is none at the end, or one below `--min`."""

    def __init__(self, options: MeasureOptions) -> None:
        super().__init__(options)
        self._accepts = compiled_filter(options.filter)
        self.is_raw = self._accepts is None
        self._arrivals: dict[str, statistics.Arrivals] = defaultdict(
            lambda: statistics.Arrivals(options.window)
        )
        self._quiet: dict[str, _Quiet] = {}

    def found(self, target: TopicTarget) -> None:
        if not self.is_alone and not self.options.json:
            self.say(f"Subscribed to [{target.name}]")
        if self.options.topics:  # of all topics, most may be silent
            self._quiet[target.name] = _Quiet(target.name)

    def take(self, sample: ReceivedMessage, received_ns: int) -> None:
        if sample.is_history:
            return
        if sample.topic in self._quiet:
            self._quiet[sample.topic].message()
        if self._accepts is None or self._accepts(sample.message):
            self._arrivals[sample.topic].add(received_ns)

    def report(self) -> None:
        due = {name: one for name in self.topics if (one := self._arrivals[name].due())}
        for quiet in self._quiet.values():
            quiet.check()
        if self.options.json:
            for name, one in due.items():
                print_line({"topic": name, "event": "rate", **_document(one, "rate_hz", "mean_hz")})
        elif due and self.is_alone:
            self.clear()
            print(statistics.rate_text(due[self.topics[0]]))
        elif due:
            rows = [(name, *statistics.rate_cells(one)) for name, one in due.items()]
            self.print_table(statistics.RATE_HEAD, rows)

    def verdict(self, for_s: float) -> int:
        options, now_ns = self.options, self.clock.now_ns() or 0
        counts = [(name, self._arrivals[name].count) for name in self.topics]
        rates = {name: self._arrivals[name].mean_rate_hz(now_ns) for name in self.topics}
        for name, number in counts if options.json else ():
            total = {"messages": number, "mean_hz": rates[name]}
            print_line({"topic": name, "event": "total", **total})
        code = self.too_few(counts, for_s)
        for name, number in counts:
            if options.min_hz is not None and rates[name] < options.min_hz:
                code = ExitCode.PROCESS_FAILED
                if number > 1 and not options.json:
                    warn(
                        f"{name}: {rates[name]:.3f} Hz over {for_s:g} s, "
                        f"below the minimum of {options.min_hz:g} Hz"
                    )
        return code


class Bandwidths(Measurement):
    """`topic bw`: bytes per second and sizes."""

    def __init__(self, options: MeasureOptions) -> None:
        super().__init__(options)
        self._sizes: dict[str, statistics.Bandwidth] = defaultdict(
            lambda: statistics.Bandwidth(options.window)
        )
        self._reported: set[str] = set()

    def found(self, target: TopicTarget) -> None:
        if not self.options.json:
            self.say(f"Subscribed to [{target.name}]")

    def take(self, sample: ReceivedMessage, received_ns: int) -> None:
        if not sample.is_history:
            self._sizes[sample.topic].add(received_ns, len(sample.message))

    def report(self) -> None:
        self._print([n for n in self.topics if self.is_alone or self._sizes[n].has_news])

    def rest(self) -> None:
        self._print([name for name in self.topics if name not in self._reported])

    def _print(self, names: Iterable[str]) -> None:
        now_ns = self.clock.now_ns() or 0
        due = {name: one for name in names if (one := self._sizes[name].due(now_ns))}
        for name in due:
            self._reported.add(name)
            self._sizes[name].has_news = False
        if self.options.json:
            for name, one in due.items():
                print_line({"topic": name, "event": "rate", **_bandwidth_document(*one)})
        elif due and self.is_alone:
            self.clear()
            print(statistics.bandwidth_text(*due[self.topics[0]]))
        elif due:
            rows = [(name, *statistics.bandwidth_cells(*one)) for name, one in due.items()]
            self.print_table(statistics.BANDWIDTH_HEAD, rows)

    def verdict(self, for_s: float) -> int:
        now_ns = self.clock.now_ns() or 0
        for name in self.topics if self.options.json else ():
            print_line({"topic": name, "event": "total", **self._sizes[name].total(now_ns)})
        silent = (name for name in self.topics if name not in self._reported)
        return self.too_few([(name, len(self._sizes[name])) for name in silent], for_s)


class Ages(Measurement):
    """`topic delay`: the ages of the messages of one topic when they arrive."""

    is_raw = False

    def __init__(self, options: MeasureOptions) -> None:
        super().__init__(options)
        self._delays = statistics.Delays(options.window)
        self._is_silent = True

    def take(self, sample: ReceivedMessage, received_ns: int) -> None:
        self._delays.add(received_ns - _stamp_ns(sample.message))

    def report(self) -> None:
        due = self._delays.due()
        if due is None:
            return
        self._is_silent = False
        spread, fresh = due
        if self.options.json:
            document = _document(spread, "mean_s", "mean_s")
            head = {"topic": self.topics[0], "event": "delay"}
            print_line({**head, **document, "fresh": fresh})
        else:
            print(statistics.delay_text(spread, fresh=fresh))

    def rest(self) -> None:
        if self._is_silent:
            self.report()

    def verdict(self, for_s: float) -> int:
        return nothing_came(self.topics, for_s) if self._is_silent else ExitCode.OK


def _document(spread: statistics.Spread, mean: str, key: str) -> dict[str, Any]:
    spreads = {n: getattr(spread, n) for n in ("min_s", "max_s", "std_dev_s", "window")}
    return {key: getattr(spread, mean), **spreads}


def _bandwidth_document(rate: float, sizes: list[int]) -> dict[str, Any]:
    least, most = min(sizes), max(sizes)
    return {"bytes_per_s": rate, "messages": len(sizes), "min_bytes": least, "max_bytes": most}


def _stamp_ns(message: Any) -> int:
    try:
        stamp = message.header.stamp
    except AttributeError:
        raise VerbError(
            "msg does not have header", hint=f"{type(message).__name__} carries no time stamp"
        ) from None
    return int(stamp.sec) * statistics.NANOS + int(stamp.nanosec)
