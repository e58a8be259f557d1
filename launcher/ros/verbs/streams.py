"""`topic echo`, and the end of listening: enough has arrived, or Ctrl-C."""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.ros.topics.echo import Writer, compiled_filter
from launcher.ros.topics.listener import Listener
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import GraphAccess, clear_screen, named_node, observing, warn
from launcher.ros.verbs.awaited_topics import TopicSubscriber, are_published


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
    clear: bool
    timeout_s: float | None
    node_name: str | None


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
        named_node(observer, options.node_name) as node,
    ):
        listener = Listener(observer, raw=writer.raw, node=node)
        subscriber = TopicSubscriber(
            observer, listener, options.qos, options.access.spin_time_s, json=writer.json
        )
        for name in options.topics:
            subscriber.subscribe_now(name, options.type)
        limit = ListeningLimit(options.timeout_s)
        write = sys.stdout.write
        for sample in listener.samples(limit.tick):
            limit.is_fresh = True
            values = writer.values(sample)
            if accepts and not writer.raw:
                values = [(path, value) for path, value in values if accepts(value)]
            if not values:
                continue
            is_silent = False
            if options.clear:
                clear_screen()
            for piece in writer.pieces(sample, values):
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
