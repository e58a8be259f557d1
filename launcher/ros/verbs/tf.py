"""`tf VERB ...`: transforms between frames, and the tree of frames, without tf2."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterable, Iterator
from decimal import Decimal, InvalidOperation
from typing import TYPE_CHECKING

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.option import JSON_LINES, Option, count, load, option, positive_seconds
from launcher.base.verb_table import BAG_TRANSFORMS, VERBS
from launcher.ros.verb import (
    SIM_TIME,
    GraphAccess,
    dispatch,
    domain_option,
    observing,
    print_json,
    ros_command,
    seconds,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.tf.frame_buffer import TransformBuffer
    from launcher.ros.tf.frame_tree import TfSample
    from launcher.ros.tf.tf_echo import TfEchoOptions
    from launcher.ros.topics.clock import WallClock


_SPIN_S = 0.1


def _rate(word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        text = f"Failed to convert rate argument '{word}' to a floating-point number"
        raise ValueError(text) from None
    if not 0.0 < value < float("inf"):
        raise ValueError("Rate must be positive")
    return value


def _time_ns(word: str) -> int:
    try:
        return int(Decimal(word) * 1_000_000_000)
    except (InvalidOperation, ValueError, OverflowError):
        text = f"Failed to convert time argument '{word}' to a floating-point number"
        raise ValueError(text) from None


def _digits(word: str) -> int:
    if word.startswith("-") and word[1:].isdigit():
        raise ValueError("Precision must be non-negative")
    try:
        return count(word, 0, 100)
    except ValueError:
        raise ValueError(f"Failed to convert precision argument '{word}' to an integer") from None


def _topics(options: Parsed) -> tuple[str, str]:
    return full_name(options.tf_topic), full_name(options.tf_static_topic)


def _received(options: Parsed, clock: WallClock, tick: Callable[[], bool]) -> Iterator[TfSample]:
    """The messages of the graph until `tick` returns False."""
    from launcher.ros.tf.tf_listener import TfListener, require_type
    from launcher.ros.verbs.awaited_topics import are_published

    require_type()
    topics = _topics(options)
    access = GraphAccess.of(options)
    with observing(access, are_published(topics), listens=True) as observer:
        clock.start(observer)
        yield from TfListener(observer, topics, access.spin_time_s).samples(tick)
        clock.stop()


def _limit(limit_s: float | None) -> Callable[[], bool]:
    """Whether it is not over; it begins when this is first asked, after the discovery."""
    start_s: float | None = None

    def is_going_on() -> bool:
        nonlocal start_s
        now_s = time.monotonic()
        start_s = now_s if start_s is None else start_s
        return limit_s is None or now_s < start_s + limit_s

    return is_going_on


def _clock(options: Parsed) -> WallClock:
    from launcher.ros.topics.clock import clock_of

    return clock_of(simulated=options.use_sim_time)


def _of_bag(options: Parsed) -> Iterator[TfSample]:
    found: Iterator[TfSample] = load(BAG_TRANSFORMS)(options.bag, _topics(options))
    return found


def _refuse_names(frames: Iterable[str]) -> None:
    """UsageError for a name that no frame can have, as tf2 says at each lookup."""
    for frame in frames:
        if not frame:
            raise UsageError("the name of a frame is empty", hint="is a shell variable unset?")
        if frame.startswith("/"):
            text = f"'{frame}': in tf2 the name of a frame cannot begin with a slash"
            raise UsageError(text, hint=f"did you mean {frame.lstrip('/')}?")


# ---- echo


def _echo(options: Parsed) -> int:
    from launcher.ros.tf.tf_echo import TfEchoOptions
    from launcher.ros.verbs.streams import until_interrupted

    _refuse_names((options.frame, options.other))
    chosen = TfEchoOptions(
        frame=options.frame,
        other=options.other,
        period_s=1.0 / options.rate,
        time_ns=max(0, options.time),
        digits=options.precision,
        json=options.json,
    )
    is_endless = options.bag is None and not options.once and options.timeout is None
    with until_interrupted(is_end=is_endless):
        if options.bag is not None:
            return _echo_bag(options, chosen)
        return _echo_graph(options, chosen)
    return ExitCode.OK


def _echo_graph(options: Parsed, chosen: TfEchoOptions) -> int:
    from launcher.ros.tf.frame_buffer import TransformBuffer
    from launcher.ros.tf.tf_echo import TfEcho

    buffer, clock = TransformBuffer(), _clock(options)
    echo = TfEcho(buffer, chosen)
    is_going_on = _limit(options.timeout)

    def tick() -> bool:
        echo.step(clock.now_ns() or 0, time.monotonic())
        return is_going_on() and not (options.once and echo.printed)

    for sample in _received(options, clock, tick):
        for stamped in sample.transforms:
            buffer.add(stamped, is_static=sample.is_static)
    return ExitCode.OK if echo.printed else _no_transform(buffer, chosen)


def _echo_bag(options: Parsed, chosen: TfEchoOptions) -> int:
    """What would have been printed while the bag was recorded, or at one time."""
    from launcher.ros.tf.frame_buffer import CACHE_NS, TransformBuffer
    from launcher.ros.tf.tf_echo import TfEcho

    buffer = TransformBuffer(keep_ns=None if chosen.time_ns else CACHE_NS)
    echo, now_ns = TfEcho(buffer, chosen), 0
    for sample in _of_bag(options):
        if not chosen.time_ns and sample.received_ns != now_ns:
            echo.step(now_ns, now_ns / 1e9, waits=False)
        if options.once and echo.printed:
            return ExitCode.OK
        now_ns = sample.received_ns
        for stamped in sample.transforms:
            buffer.add(stamped, is_static=sample.is_static)
    if not echo.printed and buffer.why_not(chosen.frame, chosen.other, chosen.time_ns) is None:
        echo.show(now_ns)
    return ExitCode.OK if echo.printed else _no_transform(buffer, chosen)


def _no_transform(buffer: TransformBuffer, chosen: TfEchoOptions) -> int:
    why = buffer.why_not(chosen.frame, chosen.other, chosen.time_ns)
    warn(f"no transform {chosen.frame} -> {chosen.other}: {why}")
    return ExitCode.PROCESS_FAILED


# ---- tree


def _tree(options: Parsed) -> int:
    from launcher.ros.tf.frame_tree import FrameTree

    tree, now_ns = FrameTree(), 0
    if options.bag is not None:
        for sample in _of_bag(options):
            tree.take(sample)
            now_ns = sample.received_ns
        now_ns = tree.clock_ns(now_ns)
    else:
        clock = _clock(options)
        for sample in _received(options, clock, _limit(options.wait_time)):
            tree.take(sample)
        if (time_ns := clock.now_ns()) is None:
            return _no_clock(options.wait_time)
        now_ns = time_ns
    if options.output:
        _draw(options.output, tree.dot(now_ns))
    elif options.dot:
        print(tree.dot(now_ns), end="")
    elif options.json:
        print_json(tree.document(now_ns))
    else:
        for line in tree.lines(now_ns):
            print(line)
    if tree.courses:
        is_judged = not (options.dot or options.output)
        has_problem = is_judged and bool(tree.problems(now_ns))
        return ExitCode.PROCESS_FAILED if has_problem else ExitCode.OK
    where = options.bag or f"{options.wait_time:g} s"
    warn(f"no transforms on {' and '.join(_topics(options))} within {where}")
    return ExitCode.PROCESS_FAILED


def _no_clock(limit_s: float) -> int:
    warn(f"no time on /clock within {limit_s:g} s")
    return ExitCode.PROCESS_FAILED


def _draw(name: str, dot: str) -> None:
    from launcher.ros.draw.dot import to_svg

    _write(f"{name}.gv", dot)
    _write(f"{name}.svg", to_svg(dot))


def _write(path: str, text: str) -> None:
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise LauncherError(f"{path}: {error.strerror}") from None
    warn(f"wrote {path}")


# ---- monitor


def _monitor(options: Parsed) -> int:
    from launcher.ros.verbs.streams import until_interrupted

    if len(options.frames) not in (0, 2):
        raise UsageError("usage: tf monitor [A B]", hint="two frames, or none for all")
    _refuse_names(options.frames)
    with until_interrupted(is_end=options.for_s is None):
        return _monitor_graph(options)
    return ExitCode.OK


def _monitor_graph(options: Parsed) -> int:
    from launcher.ros.tf.tf_monitor import TfMonitor

    clock = _clock(options)
    monitor = TfMonitor(options.frames, json=options.json, for_s=options.for_s)
    is_going_on = _limit(options.for_s)

    early: list[TfSample] = []  # before the first time on /clock; static ones do not come again

    def taken_ns() -> int | None:
        if (now_ns := clock.now_ns()) is not None:
            for one in early:
                monitor.take(one, now_ns)
            early.clear()
        return now_ns

    def tick() -> bool:
        if (now_ns := taken_ns()) is not None:
            monitor.step(now_ns, time.monotonic())
        return is_going_on()

    for sample in _received(options, clock, tick):
        early.append(sample)
        taken_ns()
    if clock.now_ns() is None:
        return _no_clock(options.for_s)
    if not monitor.has_data:
        warn(f"no transforms on {' and '.join(_topics(options))} within {options.for_s:g} s")
        return ExitCode.PROCESS_FAILED
    if (why := monitor.why_not()) is not None:
        warn(f"no chain {' -> '.join(options.frames)}: {why}")
        return ExitCode.PROCESS_FAILED
    monitor.report()
    return ExitCode.OK


# ---- static


def _static(options: Parsed) -> int:
    from launcher.ros.tf import static_transform
    from launcher.ros.tf.tf_listener import require_type
    from launcher.ros.verbs.publish import participant_profile
    from launcher.ros.verbs.streams import until_interrupted

    names = [one.name for one in _STATIC]
    given = {name: getattr(options, name) for name in names}
    stamped = static_transform.parsed(given, options.words)
    message_class = require_type()
    with until_interrupted():
        from launcher.ros.discovery.observer import Observer

        name = static_transform.node_name()
        with Observer(domain_option(options), name=name, profile=participant_profile()) as observer:
            from rclpy.executors import SingleThreadedExecutor

            publisher = static_transform.publish(observer.node, stamped, message_class)
            executor = SingleThreadedExecutor(context=observer.context)
            executor.add_node(observer.node)
            while publisher:  # a longer wait would not end with a signal
                executor.spin_once(timeout_sec=_SPIN_S)
    return ExitCode.OK


_STATIC = (
    option("--frame-id FRAME", "the parent"),
    option("--child-frame-id FRAME", "the child"),
    *(option(f"--{name} M", f"translation along {name}") for name in "xyz"),
    *(
        option(f"--{name} RAD", f"rotation about {axis}")
        for name, axis in zip(("roll", "pitch", "yaw"), "xyz", strict=True)
    ),
    *(option(f"--q{name} N", f"or {name} of a quaternion") for name in "xyzw"),
)

_TOPICS = (
    option("--tf-topic, --tf_topic NAME", "topic of moving transforms", default="/tf"),
    option(
        "--tf-static-topic, --tf_static_topic NAME",
        "topic of static transforms",
        default="/tf_static",
    ),
)


def _command(name: str, help: str, run: Callable[[Parsed], int], *more: Option) -> Command:
    return ros_command(f"tf {name}", help, run, *more, *_TOPICS, SIM_TIME, json=JSON_LINES)


COMMAND = Command(
    "tf",
    VERBS["tf"],
    commands=(
        _command(
            "echo",
            "print the transform from OTHER into FRAME, as tf2_echo",
            _echo,
            option("FRAME"),
            option("OTHER"),
            option("-r, --rate HZ", "how often (default: 1)", _rate, 1.0),
            option("-t, --time S", "at this time, instead of the latest", _time_ns, 0),
            option("-p, --precision N", "digits (default: 3)", _digits, 3),
            option("--once", "end after the first transform"),
            option("--timeout S", "end after S seconds, with 1 if there was none", seconds),
            option("--bag BAG", "as while this bag was recorded"),
        ),
        ros_command(
            "tf tree",
            "print the tree of frames and its problems",
            _tree,
            option("[BAG]", "a bag, instead of the graph"),
            option("-t, --wait-time S", "listen for S seconds", positive_seconds, 5.0),
            option("--dot", "print the source for Graphviz"),
            option("-o, --output NAME", "write NAME.gv and NAME.svg"),
            *_TOPICS,
            SIM_TIME,
            exclusive=(("dot", "output", "json"),),
        ),
        _command(
            "monitor",
            "print delays of frames, as tf2_monitor",
            _monitor,
            option("[FRAME ...]", "two frames, or none for all", name="frames"),
            option("--for S", "end after S seconds", seconds, name="for_s"),
        ),
        ros_command(
            "tf static",
            "publish a transform, as static_transform_publisher",
            _static,
            option(
                "[WORD ...]",
                "without options: x y z yaw pitch roll, or x y z qx qy qz qw, "
                "then parent and child (deprecated)",
                name="words",
            ),
            *_STATIC,
            json=None,
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
