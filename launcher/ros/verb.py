"""Verb: what the command lines of all ROS verbs share: options, the look at the graph, output."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NoReturn, TextIO, cast

from launcher.errors import ExitCode, UsageError
from launcher.ros.discovery import domains
from launcher.ros.discovery.graph_socket import snapshot_of_run
from launcher.ros.snapshot.graph import GraphSnapshot

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.discovery.prefetch import Prefetch


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaints are UsageErrors."""

    def error(self, message: str) -> NoReturn:
        """Raise instead of printing and exiting."""
        raise UsageError(message, hint=f"{self.prog} --help")


def parser_of(verb: str, description: str) -> tuple[Parser, Any]:
    """The parser of a verb and the table that takes its sub-verbs (see `add_verb`)."""
    parser = Parser(prog=f"python -m launcher {verb}", description=description)
    table = parser.add_subparsers(dest="sub", metavar="VERB", parser_class=Parser)
    return parser, table


def add_verb(table: Any, name: str, help_text: str) -> Parser:
    """One sub-verb with the options that all have."""
    parser: Parser = table.add_parser(name, help=help_text, description=help_text)
    add_common(parser)
    return parser


def add_common(parser: argparse.ArgumentParser) -> None:
    """The options that all verbs have."""
    parser.add_argument("-d", "--domain", metavar="ID", help="look at this ROS domain")
    parser.add_argument(
        "--spin-time",
        type=seconds,
        metavar="S",
        help="longest wait until the graph is complete and quiet (default 3.5)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    parser.add_argument(
        "--no-observer", action="store_true", help="look ourselves, even if a run's bridge knows"
    )
    parser.add_argument("--no-daemon", action="store_true", help="accepted: there is no daemon")


def dispatch(
    parser: Parser, run: Mapping[str, Callable[[argparse.Namespace], int]], words: Sequence[str]
) -> int:
    """Parse and run a sub-verb; the help if there is none. SIGTERM ends it as Ctrl-C does."""
    _refuse_undecodable(words)
    options = parser.parse_args(list(words))
    if options.sub is None:
        parser.print_help()
        return ExitCode.OK
    # an orderly end takes our node out of the graph at once, and our shared memory off the disk
    for signum in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(signum, signal.default_int_handler)
    try:
        with escaped_output():
            return run[options.sub](options)
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


def seconds(word: str) -> float:
    """A time that is not negative, for argparse."""
    value = float(word)
    if not 0 <= value < 1e9:
        raise argparse.ArgumentTypeError(f"not a time in seconds: '{word}'")
    return value


def require_rate(rate_hz: float) -> None:
    """UsageError for what is no rate; of a period above 30 years nobody sees the end."""
    if rate_hz <= 0:
        raise UsageError("rate must be greater than zero")
    if not 1e-9 <= rate_hz < math.inf:
        raise UsageError(f"no rate in Hz: {rate_hz}")


def domain_option(options: argparse.Namespace) -> int:
    """The domain of `-d`, or that of the environment."""
    from launcher.ros.discovery.domains import domain_of, environment_domain

    return environment_domain() if options.domain is None else domain_of(options.domain, "-d")


@contextlib.contextmanager
def observing(
    options: argparse.Namespace,
    enough: Callable[[GraphSnapshot], object] | None = None,
    *,
    listens: bool = False,
) -> Iterator[Observer]:
    """An observer of the domain that is asked for, before it has looked round.

    Meanwhile a scout looks by the wire, until it has seen all, or `enough`. Who `listens` to
    others and says nothing to them knows them sooner.
    """
    with _scouting(options, enough, listens=listens) as scout:
        from launcher.ros.discovery.observer import Observer  # takes its time, with rclpy

        with Observer(domain_option(options), scout=scout) as observer:
            yield observer


@contextlib.contextmanager
def _scouting(
    options: argparse.Namespace, enough: Callable[[GraphSnapshot], object] | None, *, listens: bool
) -> Iterator[Prefetch | None]:
    """None where it takes a whole DDS stack to look."""
    from launcher.ros.discovery import domains
    from launcher.ros.discovery.prefetch import Prefetch, never

    domain_id = domain_option(options)
    if not domains.is_plain():
        yield None
        return
    with contextlib.closing(
        Prefetch(
            domain_id,
            spin_time_s(options),
            remote=not domains.localhost_only(),
            enough=enough or never,
            listens=listens,
        )
    ) as scout:
        yield scout


def spin_time_s(options: argparse.Namespace) -> float:
    """How long discovery may take."""
    from launcher.ros.discovery.domains import SPIN_TIME_S

    return SPIN_TIME_S if options.spin_time is None else float(options.spin_time)


@contextlib.contextmanager
def settled_observer(options: argparse.Namespace) -> Iterator[Observer]:
    """An observer that has seen the whole graph; what it could not see is said on stderr."""
    from launcher.ros.discovery.completeness import settle

    with observing(options) as observer:
        result = settle(observer, spin_time_s(options))
        names = observer.node_names()
        warn_if_incomplete(observer.domain_id, names, result.missing, result.waited_s)
        yield observer


def warn_if_incomplete(domain_id: int, nodes: Sequence[str], missing: int, waited_s: float) -> None:
    """Say on stderr that there is nothing, or that there may be more."""
    from launcher.ros.discovery.domains import why_empty

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


def print_json(document: Any) -> None:
    """One document; what JSON has no word for (nan, inf) as strings."""
    print(json.dumps(_without_nan(document), ensure_ascii=False, indent=2, allow_nan=False))


def _without_nan(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    return [_without_nan(item) for item in value] if isinstance(value, list) else value


# Everything that a terminal takes for a command; with it a message could retitle a window, hide
# lines or, in some terminals, type. Line ends and tabs are text.
_STEERING = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def without_commands(text: str) -> str:
    """The text with control characters as escapes: `\\x1b`."""
    return _STEERING.sub(lambda match: f"\\x{ord(match[0]):02x}", text)


class _Harmless:
    """A stream to a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write what is harmless."""
        self._stream.write(without_commands(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextlib.contextmanager
def escaped_output() -> Iterator[None]:
    """Inside, nothing that is printed steers a terminal; files and pipes get every byte."""
    kept = sys.stdout, sys.stderr
    guarded = [cast("TextIO", _Harmless(s)) if s and s.isatty() else s for s in kept]
    sys.stdout, sys.stderr = guarded
    try:
        yield
    finally:
        if sys.stdout is guarded[0]:  # somebody may have put it away for good
            sys.stdout = kept[0]
        sys.stderr = kept[1]


def graph_snapshot(options: argparse.Namespace) -> GraphSnapshot:
    """The graph of the domain that is asked for; what could not be seen is said on stderr."""
    if not options.no_observer and (look := snapshot_of_run(domain_option(options))):
        warn_if_incomplete(look.domain_id, look.nodes, 0, 0.0)
        return look
    if domains.is_plain() and (look := _by_wire(options)):
        return look
    with settled_observer(options) as observer:
        return observer.look()


def _by_wire(options: argparse.Namespace) -> GraphSnapshot | None:
    """None if it takes a whole DDS stack."""
    from launcher.ros.discovery.reader import UnsupportedDiscovery, read_graph

    domain_id = domain_option(options)
    remote = not domains.localhost_only()
    try:
        found = read_graph(domain_id, spin_time_s(options), remote=remote)
    except (UnsupportedDiscovery, OSError):
        return None
    warn_if_incomplete(domain_id, found.look.nodes, found.missing, found.waited_s)
    return found.look
