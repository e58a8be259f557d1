"""Streams: `topic echo`, `hz`, `bw` and `delay`: listen until enough is heard or Ctrl-C."""

from __future__ import annotations

import contextlib
import json
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from launcher.command_line import Parsed
from launcher.errors import ExitCode
from launcher.graph import rates
from launcher.graph.echo import Writer, compiled_filter
from launcher.graph.errors import VerbError
from launcher.graph.listener import Listener, Target, are_published, full_topic
from launcher.graph.subscribing import Awaited, subscribe_now
from launcher.graph.verb import looking, warn

SILENCE_S = 3.0


@contextlib.contextmanager
def until_interrupted() -> Iterator[None]:
    """Ctrl-C is how these verbs usually end; a closed pipe ends them as well."""
    try:
        yield
        sys.stdout.flush()
    except KeyboardInterrupt:
        sys.stdout.flush()
    except BrokenPipeError:
        # what the interpreter flushes at its end must not complain again
        sys.stdout = open("/dev/null", "w")  # noqa: SIM115


def echo(options: Parsed) -> int:
    """Print messages; the exit code."""
    writer, accepts = Writer.of(options), compiled_filter(options.filter)
    enough = are_published(options.topic_names)
    with until_interrupted(), looking(options, enough, listens=True) as observer:
        listener = Listener(observer, raw=options.raw)
        for name in options.topic_names:
            subscribe_now(observer, listener, name, options)
        silence = _Silence(options.timeout)
        write = sys.stdout.write
        for sample in listener.samples(silence.tick, warn):
            silence.broken()
            value = writer.value(sample)
            if accepts and not options.raw and not accepts(value):
                continue
            for piece in writer.pieces(sample, value):
                write(piece)
            if options.once:
                break
    return ExitCode.OK


class _Silence:
    """Ends a listening after some seconds without a message; flushes after each burst."""

    def __init__(self, timeout_s: float | None) -> None:
        self._timeout_s = timeout_s
        self._last = time.monotonic()
        self._fresh = False

    def broken(self) -> None:
        """A message has come."""
        self._last = time.monotonic()
        self._fresh = True

    def tick(self) -> bool:
        """Whether to go on."""
        if self._fresh:
            sys.stdout.flush()
            self._fresh = False
        return self._timeout_s is None or time.monotonic() - self._last < self._timeout_s


class _Clock:
    """Ends a measurement after `for_s`, and calls `report` once a second until then.

    Meanwhile it looks for the topics that are awaited.
    """

    def __init__(self, for_s: float | None, awaited: Awaited, report: Callable[[], None]) -> None:
        self._awaited = awaited
        self._start = time.monotonic()
        self._end = None if for_s is None else self._start + for_s
        self._next = self._start + 1.0
        self._report = report

    def tick(self) -> bool:
        """Whether to go on."""
        self._awaited.look()
        now = time.monotonic()
        if now >= self._next:
            self._next += 1.0
            self._report()
            sys.stdout.flush()
        return self._end is None or now < self._end


class _Quiet:
    """Says on stderr, once per silence, that a topic has become silent."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._last = time.monotonic()
        self._said = False

    def message(self) -> None:
        """One has come."""
        self._last, self._said = time.monotonic(), False

    def look(self) -> None:
        """Say it if it is so."""
        gap_s = time.monotonic() - self._last
        if gap_s >= SILENCE_S and not self._said:
            self._said = True
            warn(f"no message on {self._topic} for {gap_s:.1f} s")


def hz(options: Parsed) -> int:
    """Print rates; 1 if one of them is below `--min` at the end."""
    accepts = compiled_filter(options.filter)
    names = options.topic_names
    arrivals: dict[str, rates.Arrivals] = {}
    quiet: dict[str, _Quiet] = {}

    def found(target: Target) -> None:
        quiet[target.name] = _Quiet(target.name)

    with until_interrupted(), looking(options, are_published(names), listens=True) as observer:
        listener = Listener(observer, raw=accepts is None)
        arrivals |= {full_topic(name): rates.Arrivals(options.window) for name in names}
        awaited = Awaited(observer, listener, names, options, found)
        clock = _Clock(options.for_s, awaited, lambda: _report_rates(arrivals, quiet, options))
        for sample in listener.samples(clock.tick, warn):
            quiet[sample.topic].message()
            if accepts is None or accepts(sample.message):
                arrivals[sample.topic].add(sample.received_ns)
    if options.for_s is None:
        return ExitCode.OK
    return _verdict(arrivals, options)


def _report_rates(
    arrivals: dict[str, rates.Arrivals], quiet: dict[str, _Quiet], options: Parsed
) -> None:
    found = {name: spread for name, a in arrivals.items() if (spread := a.due())}
    for one in quiet.values():
        one.look()
    if not found:
        return
    if options.json:
        for name, spread in found.items():
            print(json.dumps(_rate_document(name, spread)))
    elif len(arrivals) == 1:
        print(rates.rate_text(next(iter(found.values()))))
    else:
        # a table that topics come into and go out of could not be read
        print(rates.rate_table({n: spread for n, a in arrivals.items() if (spread := a.now())}))


def _rate_document(name: str, spread: rates.Spread) -> dict[str, Any]:
    return {
        "topic": name,
        "rate_hz": spread.rate_hz,
        "min_s": spread.min_s,
        "max_s": spread.max_s,
        "std_dev_s": spread.std_dev_s,
        "window": spread.window,
    }


def _verdict(arrivals: dict[str, rates.Arrivals], options: Parsed) -> int:
    now_ns, code = time.time_ns(), ExitCode.OK
    for name, one in arrivals.items():
        mean_hz = one.mean_rate_hz(now_ns)
        line = {"topic": name, "messages": one.count, "mean_rate_hz": mean_hz}
        if options.json:
            print(json.dumps(line))
        elif options.min_hz is not None and mean_hz < options.min_hz:
            warn(
                f"{name}: {mean_hz:.3f} Hz over {options.for_s:g} s, "
                f"below the minimum of {options.min_hz:g} Hz"
            )
        if options.min_hz is not None and mean_hz < options.min_hz:
            code = ExitCode.PROCESS_FAILED
    return code


def bw(options: Parsed) -> int:
    """Print bandwidths; the exit code."""
    sizes = rates.Bandwidth(options.window)

    def report() -> None:
        if found := sizes.due(time.time_ns()):
            print(_bandwidth_line(*found, as_json=options.json))

    def found(target: Target) -> None:
        if not options.json:
            print(f"Subscribed to [{target.name}]", flush=True)

    names = [options.topic_name]
    with until_interrupted(), looking(options, are_published(names), listens=True) as observer:
        listener = Listener(observer, raw=True)
        awaited = Awaited(observer, listener, names, options, found)
        for sample in listener.samples(_Clock(options.for_s, awaited, report).tick, warn):
            sizes.add(sample.received_ns, len(sample.message))
    return ExitCode.OK


def _bandwidth_line(rate: float, sizes: list[int], *, as_json: bool) -> str:
    if not as_json:
        return rates.bandwidth_text(rate, sizes)
    document = {"bytes_per_s": rate, "messages": len(sizes), "min": min(sizes), "max": max(sizes)}
    return json.dumps(document)


def delay(options: Parsed) -> int:
    """Print delays; the exit code."""
    delays = rates.Delays(options.window)

    def report() -> None:
        if due := delays.due():
            print(_delay_line(*due, as_json=options.json))

    names = [options.topic_name]
    with until_interrupted(), looking(options, are_published(names), listens=True) as observer:
        listener = Listener(observer, raw=False)
        awaited = Awaited(observer, listener, names, options, lambda target: None)
        for sample in listener.samples(_Clock(options.for_s, awaited, report).tick, warn):
            delays.add(sample.received_ns - _stamp_ns(sample.message))
    return ExitCode.OK


def _delay_line(spread: rates.Spread, fresh: bool, *, as_json: bool) -> str:
    if not as_json:
        return rates.delay_text(spread, fresh=fresh)
    names = ("mean_s", "min_s", "max_s", "std_dev_s", "window")
    return json.dumps({**{name: getattr(spread, name) for name in names}, "fresh": fresh})


def _stamp_ns(message: Any) -> int:
    try:
        stamp = message.header.stamp
    except AttributeError:
        raise VerbError(
            "msg does not have header", hint=f"{type(message).__name__} carries no time stamp"
        ) from None
    return int(stamp.sec) * rates.NANOS + int(stamp.nanosec)
