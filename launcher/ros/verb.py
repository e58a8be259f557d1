"""Shared by all ROS verbs: options, access to the graph, output."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TextIO, cast

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, UsageError
from launcher.base.model.record import Record
from launcher.base.option import DEBUG, JSON, Option, option
from launcher.base.option import seconds as any_seconds
from launcher.base.text import count, escape_controls
from launcher.posix import json_output
from launcher.posix.dispositions import heeded

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.snapshot.ros_graph import GraphSnapshot


def seconds(word: str) -> float:
    """A time below thirty years; ValueError."""
    value = any_seconds(word)
    if value >= 1e9:
        raise ValueError(f"'{word}' is not a number of seconds below 1e9")
    return value


_DOMAIN = option("-d, --domain ID", "ROS domain (default: ROS_DOMAIN_ID)")
_LONG_DOMAIN = option("--domain ID", "ROS domain (default: ROS_DOMAIN_ID)")
_COMMON_OPTIONS = (
    option(
        "--spin-time S",
        "longest wait until the graph is complete and quiet (default: 3.5; 10 with a discovery "
        "server)",
        seconds,
    ),
    DEBUG,
    option("--no-observer", "do not ask the observer of a run with --ros"),
    option("--no-daemon", "ignored, for compatibility with ros2"),
)
DOMAIN_OPTIONS = (_DOMAIN, JSON, *_COMMON_OPTIONS)
_WITHOUT_GRAPH = ("interface",)
SIM_TIME = option("-s, --use-sim-time", "use the time on /clock")
_NO_SIM_TIME = option("-s, --use-sim-time", "ignored, for compatibility with ros2")


def ros_command(
    name: str,
    help_text: str,
    run: Callable[[Parsed], int],
    *entries: Option,
    groups: tuple[tuple[str, tuple[Option, ...]], ...] = (),
    exclusive: tuple[tuple[str, ...], ...] = (),
    about: str = "",
    json: Option | None = JSON,
) -> Command:
    """A command with these arguments and options, and those that all ROS verbs have.

    The domain has no `-d` where that is something else. `json` None: it has no answer in JSON.
    """
    has_own = any("-s" in one.flags for one in entries)
    general = _COMMON_OPTIONS if has_own else (*_COMMON_OPTIONS, _NO_SIM_TIME)
    domain = _LONG_DOMAIN if any("-d" in one.flags for one in entries) else _DOMAIN
    entries += () if json is None else (json,)
    return Command(
        name,
        help_text,
        arguments=tuple(one for one in entries if not one.flags),
        options=tuple(one for one in entries if one.flags),
        groups=(*groups, ("options of all ROS verbs", (domain, *general))),
        about=about,
        exclusive=exclusive,
        abbreviations=True,
        run=run,
    )


def dispatch(command: Command, words: Sequence[str]) -> int:
    """Parse the words and run the command. SIGTERM ends it like Ctrl-C."""
    from launcher.ros.discovery.environment_check import check_environment

    _refuse_undecodable(words)
    options = command.parse(words)
    if "domain" in vars(options):  # it looks at a graph
        if options.command.name.partition(" ")[0] not in _WITHOUT_GRAPH:
            check_environment(os.environ)
            _warn_if_off()
        _look_as_the_run(options)
    # an orderly end removes our node from the graph and our shared memory from the disk
    for signum in heeded((signal.SIGTERM, signal.SIGHUP)):
        signal.signal(signum, signal.default_int_handler)
    try:
        with escaped_output():
            assert options.command.run is not None
            return options.command.run(options)
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED


def _warn_if_off() -> None:
    from launcher.posix import domains

    if domains.is_off():
        warn(domains.OFF)


def _look_as_the_run(options: Parsed) -> None:
    """Find nodes as the run on this domain does that has a discovery server, or peers."""
    from launcher.ros.discovery.run_settings import adopt

    if (problem := adopt(os.environ, lambda: domain_option(options))) is not None:
        warn(problem)


def _refuse_undecodable(words: Sequence[str]) -> None:
    """Text in ROS is UTF-8; only file names may be other bytes."""
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            if not os.path.exists(word):
                raise UsageError(f"not UTF-8: {word!a}") from None


def standard_input() -> str:
    """All of it; UsageError if it is not UTF-8, whatever the encoding of the locale."""
    try:
        return sys.stdin.buffer.read().decode()
    except UnicodeDecodeError:
        raise UsageError("not UTF-8: standard input") from None


def require_rate(rate_hz: float) -> None:
    """UsageError for a rate in Hz that is not positive, or means a period above 30 years."""
    if rate_hz <= 0:
        raise UsageError("rate must be greater than zero")
    if not 1e-9 <= rate_hz < math.inf:
        raise UsageError(f"no rate in Hz: {rate_hz}")


def domain_option(options: Parsed) -> int:
    from launcher.posix.domains import domain_of, environment_domain

    return environment_domain() if options.domain is None else domain_of(options.domain, "--domain")


def spin_time_s(options: Parsed) -> float:
    from launcher.posix.domains import usual_spin_time_s

    return usual_spin_time_s() if options.spin_time is None else float(options.spin_time)


def graph_snapshot(options: Parsed) -> GraphSnapshot:
    """The graph, from the quickest source there is; warns if it is empty or incomplete.

    1. The bridge of a run, if one is on the domain. 2. The discovery messages, read directly.
    3. A node of rclpy, where discovery is not plain RTPS.
    """
    return snapshot_at(GraphAccess.of(options), asks_runs=not options.no_observer)


class GraphAccess(Record):
    """The domain of the graph, and how long to wait at most until it is complete and quiet.

    `verb` is in the name of the node.
    """

    domain_id: int
    spin_time_s: float
    verb: str = "verb"

    @classmethod
    def of(cls, options: Parsed) -> GraphAccess:
        return cls(domain_option(options), spin_time_s(options), options.command.name)


def snapshot_at(access: GraphAccess, *, asks_runs: bool = True) -> GraphSnapshot:
    """As `graph_snapshot`; a run is asked only if `asks_runs`."""
    from launcher.ros.discovery.graph_socket import snapshot_of_run

    if asks_runs and (found := snapshot_of_run(access.domain_id)):
        warn_if_incomplete(found.domain_id, found.nodes, 0, 0.0)
        return found
    if found := _read_graph(access):
        return found
    with settled(access) as observer:
        return observer.graph_snapshot()


def _read_graph(access: GraphAccess) -> GraphSnapshot | None:
    """None where reading needs a whole DDS stack."""
    from launcher.posix import domains
    from launcher.ros.discovery.discovery_reader import UnsupportedDiscovery, read_graph

    if not domains.is_plain():
        return None
    try:
        remote = not domains.localhost_only()
        result = read_graph(access.domain_id, access.spin_time_s, remote=remote)
    except (UnsupportedDiscovery, OSError):
        return None
    warn_if_incomplete(access.domain_id, result.snapshot.nodes, result.missing, result.waited_s)
    return result.snapshot


@contextlib.contextmanager
def observing(
    access: GraphAccess,
    enough: Callable[[GraphSnapshot], object] = lambda graph: False,
    *,
    listens: bool = False,
    profile: str | None = None,
) -> Iterator[Observer]:
    """An rclpy observer of the domain, while discovery is still on its way.

    A `Prefetch` reads the graph meanwhile, until it is complete or `enough`. With `listens`, for
    callers that only subscribe, the endpoints of others are known sooner.
    """
    from launcher.posix import domains
    from launcher.ros.discovery.prefetch import Prefetch

    with contextlib.ExitStack() as stack:
        domain_id, prefetch = access.domain_id, None
        if domains.is_plain():
            remote = not domains.localhost_only()
            prefetch = Prefetch(
                domain_id, access.spin_time_s, remote=remote, enough=enough, listens=listens
            )
            stack.callback(prefetch.close)
        from launcher.ros.discovery.observer import Observer  # imports rclpy, which is slow

        observer = Observer(domain_id, purpose=access.verb, prefetch=prefetch, profile=profile)
        yield stack.enter_context(observer)


def settled_observer(options: Parsed) -> contextlib.AbstractContextManager[Observer]:
    """As `settled`, where and as long as the options say."""
    return settled(GraphAccess.of(options))


@contextlib.contextmanager
def named_node(observer: Observer, name: str | None) -> Iterator[Any]:
    """The hidden node of the observer, or with a name one more that others see."""
    from rclpy.exceptions import InvalidNodeNameException

    from launcher.base.ros_errors import name_fault
    from launcher.ros.helpers.clean_up import limited_clean_up

    if name is None:
        yield observer.node
        return
    try:
        node = observer.companion(name)
    except InvalidNodeNameException as error:
        raise UsageError(f"--node-name: {name_fault(error)}") from None
    try:
        yield node
    finally:
        with limited_clean_up():
            node.destroy_node()


@contextlib.contextmanager
def settled(access: GraphAccess) -> Iterator[Observer]:
    """An observer that has discovered the whole graph; warns if it is empty or incomplete."""
    from launcher.ros.discovery.completeness import settle

    with observing(access) as observer:
        result = settle(observer, access.spin_time_s)
        names = observer.node_names()
        warn_if_incomplete(observer.domain_id, names, result.missing, result.waited_s)
        yield observer


def warn_if_incomplete(domain_id: int, nodes: Sequence[str], missing: int, waited_s: float) -> None:
    """Warn that the graph is empty, or may be incomplete."""
    from launcher.posix.domains import is_off, why_empty

    if not nodes:
        if not is_off():  # which was the first line
            warn(why_empty(domain_id))
    elif missing:
        warn(
            f"{count(missing, 'participant')} on this machine did not answer within "
            f"{waited_s:.1f} s, so something may be missing (--spin-time to wait longer)"
        )


def warn(text: str) -> None:
    """A line on stderr, so that stdout stays what ros2cli prints."""
    sys.stdout.flush()
    print(text, file=sys.stderr, flush=True)


def say(text: str, *, json: bool) -> None:
    """A line beside the answers, which with --json are alone on stdout."""
    print(text, file=sys.stderr if json else sys.stdout, flush=True)


def clear_screen() -> None:
    """As ros2cli does, but only a terminal: files and pipes get no control characters."""
    if sys.stdout.isatty():
        unescaped(sys.stdout).write("\x1b[H\x1b[2J\n")


def show(options: Parsed, document: Mapping[str, object], lines: Iterable[object]) -> int:
    """Print the document with --json, the lines without; the exit code."""
    if options.json:
        print_json(document)
    else:
        for line in lines:
            print(line)
    return ExitCode.OK


def show_lines(options: Parsed, lines: Iterable[str]) -> None:
    """Print them at once, for a verb that goes on; not with --json, whose document comes later."""
    if not options.json:
        for line in lines:
            print(line, flush=True)


def show_typed(
    options: Parsed,
    kind: str,
    found: Mapping[str, Sequence[str]],
    *,
    only_count: bool,
    with_types: bool = False,
) -> int:
    """Print names, or how many there are, or names with their types; the exit code.

    `kind` is what they are: the key of their list in the document.
    """
    lines: Iterable[object] = found
    if only_count:
        lines = [len(found)]
    elif with_types:
        lines = (f"{name} [{', '.join(types)}]" for name, types in found.items())
    return show(options, {kind: typed(found.items())}, lines)


def typed(found: Iterable[tuple[str, Sequence[str]]]) -> list[dict[str, object]]:
    """Names with their types, for a document."""
    return [{"name": name, "types": list(types)} for name, types in found]


def to_json_plain(value: object) -> Any:
    """Plain values with nan and inf as strings, since JSON does not have them."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, dict):
        return {key: to_json_plain(item) for key, item in value.items()}
    return [to_json_plain(item) for item in value] if isinstance(value, list) else value


def print_json(document: Mapping[str, object]) -> None:
    json_output.print_document(to_json_plain(document))


class _EscapingStream:
    """A stream to a terminal that control characters of nodes cannot change."""

    def __init__(self, stream: TextIO) -> None:
        self.terminal = stream

    def write(self, text: str) -> int:
        self.terminal.write(escape_controls(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.terminal, name)


def unescaped(stream: Any) -> TextIO:
    """The terminal itself, for control characters that no node has sent."""
    return cast("TextIO", stream.terminal if isinstance(stream, _EscapingStream) else stream)


@contextlib.contextmanager
def escaped_output() -> Iterator[None]:
    """Print control characters to terminals as escapes; files and pipes get every byte."""
    kept = sys.stdout, sys.stderr
    escaping = [cast("TextIO", _EscapingStream(s)) if s and s.isatty() else s for s in kept]
    sys.stdout, sys.stderr = escaping
    try:
        yield
    finally:
        if sys.stdout is escaping[0]:  # otherwise it was replaced for good
            sys.stdout = kept[0]
        sys.stderr = kept[1]
