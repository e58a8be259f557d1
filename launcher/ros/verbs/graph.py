"""`graph`: the ROS graph as a tree, a drawing or data, and its differences from a saved one."""

from __future__ import annotations

import functools
import time
from pathlib import Path
from typing import TYPE_CHECKING

from launcher.base.command_line import Parsed
from launcher.base.errors import ExitCode, LauncherError
from launcher.base.model.record import replace
from launcher.base.option import JSON, option
from launcher.base.verb_table import VERBS
from launcher.posix.json_output import print_line
from launcher.ros.verb import (
    dispatch,
    graph_snapshot,
    print_json,
    ros_command,
    seconds,
    settled_observer,
    show,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.draw.filter import Filter
    from launcher.ros.snapshot.ros_graph import TopicGraph


def _graph(options: Parsed) -> int:
    from launcher.ros.draw.filter import Filter, Mode
    from launcher.ros.snapshot import diff

    chosen = Filter(
        mode=Mode(options.mode),
        include=options.include,
        exclude=options.exclude,
        debug=options.debug_topics,
        hidden=options.hidden,
    )
    chosen.check()  # before any waiting
    before = None if options.diff is None else diff.load(options.diff)
    if options.watch:
        with settled_observer(options) as observer:
            return _watch(observer, chosen, options)
    found = graph_snapshot(options)
    snapshot = chosen.apply(found.topic_graph())
    if before is not None:
        return _diff(chosen.apply(before), snapshot, options)
    _show(snapshot, chosen, options, found.domain_id)
    return ExitCode.OK


def _show(snapshot: TopicGraph, chosen: Filter, options: Parsed, domain_id: int) -> None:
    if options.json:
        from launcher.ros.snapshot.diff import to_document

        print_json(to_document(snapshot))
    elif options.mermaid:
        from launcher.ros.draw.mermaid import to_mermaid

        print(to_mermaid(snapshot, chosen.mode), end="")
    elif options.dot or options.svg or options.html:
        _draw(snapshot, chosen, options, domain_id)
    else:
        from launcher.ros.draw.graph_text import to_tree

        print(to_tree(snapshot, chosen.mode), end="")


def _draw(snapshot: TopicGraph, chosen: Filter, options: Parsed, domain_id: int) -> None:
    from launcher.ros.draw.dot import to_dot, to_html, to_svg

    dot = to_dot(snapshot, chosen.mode)
    if options.dot:
        print(dot, end="")
        return
    drawing = to_svg(dot)
    if options.svg:
        _write(options.svg, drawing)
        return
    caption = f"{len(snapshot.nodes)} nodes, {len(snapshot.topics())} topics"
    _write(options.html, to_html(drawing, title=f"ROS domain {domain_id}", caption=caption))


def _write(path: str, text: str) -> None:
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise LauncherError(f"{path}: {error.strerror}") from None
    warn(f"wrote {path}")


def _diff(before: TopicGraph, after: TopicGraph, options: Parsed) -> int:
    from launcher.ros.snapshot.diff import difference

    lines = difference(before, after)
    show(options, {"differences": [_change(line) for line in lines]}, lines)
    return ExitCode.PROCESS_FAILED if lines else ExitCode.OK


def _change(line: str) -> dict[str, object]:
    """A line of `difference`, for JSON."""
    sign, _, text = line.partition(" ")
    return {"change": "new" if sign == "+" else "gone", "text": text}


def _watch(observer: Observer, chosen: Filter, options: Parsed) -> int:
    from launcher.ros.draw.graph_text import to_tree
    from launcher.ros.snapshot.diff import difference
    from launcher.ros.verbs.streams import until_interrupted

    print_text = functools.partial(print, flush=True)
    with until_interrupted():
        before = chosen.apply(observer.topic_graph())
        if not options.json:
            print_text(to_tree(before, chosen.mode))
        while True:
            time.sleep(options.period)
            after = chosen.apply(observer.topic_graph())
            for line in difference(before, after):
                if options.json:
                    print_line({"wall_s": time.time(), **_change(line)})
                else:
                    print_text(f"{time.strftime('%H:%M:%S')} {line}")
            before = after
    return ExitCode.OK


COMMAND = ros_command(
    "graph",
    VERBS["graph"],
    _graph,
    option(
        "--mode MODE",
        "draw no topics, those with both a publisher and a subscription, or all",
        default="all",
        choices=("nodes", "active", "all"),
    ),
    option("--include RE", "only matching names and their neighbours"),
    option("--exclude RE", "no matching names"),
    option("--debug-topics", "/rosout and /parameter_events as well"),
    option("--hidden", "hidden names as well"),
    option("--dot", "print the source for Graphviz"),
    option("--mermaid", "print a flowchart for Markdown"),
    option("--svg FILE", "write a drawing"),
    option("--html FILE", "write a page with pan and zoom"),
    option("--watch", "print every change until Ctrl-C"),
    option("--diff FILE", "compare with the output of --json; exit code 1 if different"),
    option("--period S", "interval of --watch", seconds, 0.5),
    exclusive=(("dot", "mermaid", "svg", "html", "watch", "diff"),),
    json=replace(JSON, help=f"{JSON.help}; with --watch one per line"),
)

main = functools.partial(dispatch, COMMAND)
