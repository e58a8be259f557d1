"""Verb: what the command lines of all ROS verbs share: options, the look at the graph, output."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from launcher import command_line
from launcher.command_line import DEBUG, Command, Option, Parsed, option
from launcher.errors import ExitCode, UsageError
from launcher.graph.terminal import harmless

if TYPE_CHECKING:
    from launcher.graph.look import Look
    from launcher.graph.observer import Observer
    from launcher.graph.scout import Scout


def seconds(word: str) -> float:
    """A time below thirty years; ValueError."""
    value = command_line.seconds(word)
    if value >= 1e9:
        raise ValueError(f"'{word}' is not a number of seconds")
    return value


DOMAIN_OPTIONS = (
    option("-d, --domain ID", "ROS domain (default: ROS_DOMAIN_ID)"),
    option(
        "--spin-time S",
        "longest wait until the graph is complete and quiet (default: 3.5)",
        seconds,
    ),
    option("--json", "print JSON"),
    DEBUG,
    option("--no-observer", "do not ask the observer of a run with --ros"),
    option("--no-daemon", "accepted as by ros2, without effect"),
)


def ros_command(
    name: str,
    help_text: str,
    run: Callable[[Parsed], int],
    *entries: Option,
    groups: tuple[tuple[str, tuple[Option, ...]], ...] = (),
    exclusive: tuple[tuple[str, ...], ...] = (),
) -> Command:
    """A command with these arguments and options, and those that all ROS verbs have."""
    return Command(
        name,
        help_text,
        arguments=tuple(one for one in entries if not one.flags),
        options=tuple(one for one in entries if one.flags),
        groups=(*groups, ("options of all ROS verbs", DOMAIN_OPTIONS)),
        exclusive=exclusive,
        abbreviations=True,
        run=run,
    )


def dispatch(command: Command, words: Sequence[str]) -> int:
    """Parse the words and run the command. SIGTERM ends it as Ctrl-C does."""
    _refuse_undecodable(words)
    options = command.parse(words)
    # an orderly end takes our node out of the graph at once, and our shared memory off the disk
    for signum in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(signum, signal.default_int_handler)
    try:
        with harmless():
            assert options.command.run is not None
            return options.command.run(options)
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED


def _refuse_undecodable(words: Sequence[str]) -> None:
    """Text of ROS is UTF-8; only the name of a file may be anything."""
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            if not os.path.exists(word):
                raise UsageError(f"not UTF-8: {word!a}") from None


def require_rate(rate_hz: float) -> None:
    """UsageError for what is no rate; of a period above 30 years nobody sees the end."""
    if rate_hz <= 0:
        raise UsageError("rate must be greater than zero")
    if not 1e-9 <= rate_hz < math.inf:
        raise UsageError(f"no rate in Hz: {rate_hz}")


def domain_option(options: Parsed) -> int:
    """The domain of `-d`, or that of the environment."""
    from launcher.graph.domains import domain_of, environment_domain

    return environment_domain() if options.domain is None else domain_of(options.domain, "-d")


@contextlib.contextmanager
def looking(
    options: Parsed,
    enough: Callable[[Look], object] | None = None,
    *,
    listens: bool = False,
) -> Iterator[Observer]:
    """An observer of the domain that is asked for, before it has looked round.

    Meanwhile a scout looks by the wire, until it has seen all, or `enough`. Who `listens` to
    others and says nothing to them knows them sooner.
    """
    with _scouting(options, enough, listens=listens) as scout:
        from launcher.graph.observer import Observer  # takes its time, with rclpy

        with Observer(domain_option(options), scout=scout) as observer:
            yield observer


@contextlib.contextmanager
def _scouting(
    options: Parsed, enough: Callable[[Look], object] | None, *, listens: bool
) -> Iterator[Scout | None]:
    """None where it takes a whole DDS stack to look."""
    from launcher.graph import domains
    from launcher.graph.scout import Scout, never

    domain_id = domain_option(options)
    if not domains.is_plain():
        yield None
        return
    with contextlib.closing(
        Scout(
            domain_id,
            spin_time_s(options),
            remote=not domains.localhost_only(),
            enough=enough or never,
            listens=listens,
        )
    ) as scout:
        yield scout


def spin_time_s(options: Parsed) -> float:
    """How long discovery may take."""
    from launcher.graph.domains import SPIN_TIME_S

    return SPIN_TIME_S if options.spin_time is None else float(options.spin_time)


@contextlib.contextmanager
def settled(options: Parsed) -> Iterator[Observer]:
    """An observer that has seen the whole graph; what it could not see is said on stderr."""
    from launcher.graph.settle import settle

    with looking(options) as observer:
        result = settle(observer, spin_time_s(options))
        names = observer.node_names()
        tell_what_is_missing(observer.domain_id, names, result.missing, result.waited_s)
        yield observer


def tell_what_is_missing(
    domain_id: int, nodes: Sequence[str], missing: int, waited_s: float
) -> None:
    """Say on stderr that there is nothing, or that there may be more."""
    from launcher.graph.domains import why_empty

    if not nodes:
        warn(why_empty(domain_id))
    elif missing:
        warn(_incomplete(missing, waited_s))


def _incomplete(missing: int, waited_s: float) -> str:
    noun = "participant" if missing == 1 else "participants"
    return (
        f"{missing} {noun} on this machine did not answer within {waited_s:.1f} s, "
        "so something may be missing (--spin-time to wait longer)"
    )


def warn(text: str) -> None:
    """A line on stderr, so that stdout stays what ros2cli prints."""
    sys.stdout.flush()
    print(text, file=sys.stderr, flush=True)


def show(options: Parsed, document: Any, lines: Iterable[object]) -> None:
    """Print the document with --json, the lines without."""
    if options.json:
        print_json(document)
        return
    for line in lines:
        print(line)


def print_json(document: Any) -> None:
    """One document; what JSON has no word for (nan, inf) as strings."""
    print(json.dumps(_without_nan(document), ensure_ascii=False, indent=2, allow_nan=False))


def _without_nan(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    return [_without_nan(item) for item in value] if isinstance(value, list) else value
