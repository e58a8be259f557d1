"""`graph`: who talks to whom, as a tree, a drawing or data; what has changed since a saved one."""

from __future__ import annotations

import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from launcher.errors import ExitCode, LauncherError
from launcher.ros.verb import (
    Parser,
    add_common,
    dispatch,
    print_json,
    seconds,
    settled_observer,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.draw.filter import Filter
    from launcher.ros.snapshot.graph import TopicGraph


def main(words: Sequence[str]) -> int:
    """Show the graph; the exit code (1 with --diff if something differs)."""
    return dispatch(build_parser(), {"graph": _graph}, words)


def build_parser() -> Parser:
    """The options."""
    parser = Parser(prog="python -m launcher graph", description="Show who talks to whom.")
    parser.set_defaults(sub="graph")
    add_common(parser)
    _add_filters(parser)
    shape = parser.add_mutually_exclusive_group()
    shape.add_argument("--dot", action="store_true", help="print the source for Graphviz")
    shape.add_argument("--mermaid", action="store_true", help="print a flowchart for Markdown")
    shape.add_argument("--svg", metavar="FILE", help="draw it")
    shape.add_argument("--html", metavar="FILE", help="draw it on a page with pan and zoom")
    shape.add_argument("--watch", action="store_true", help="print every change until Ctrl-C")
    shape.add_argument("--diff", metavar="FILE", help="compare with a saved --json; 1 if different")
    parser.add_argument("--period", type=seconds, default=0.5, metavar="S", help="of --watch (0.5)")
    return parser


def _add_filters(parser: Parser) -> None:
    parser.add_argument(
        "--mode",
        choices=("nodes", "active", "all"),
        default="all",
        help="nodes alone, topics that connect two sides, or all topics (default)",
    )
    parser.add_argument("--include", metavar="RE", help="only names like this, with neighbours")
    parser.add_argument("--exclude", metavar="RE", help="no names like this")
    parser.add_argument(
        "--debug-topics", action="store_true", help="/rosout and /parameter_events as well"
    )
    parser.add_argument("--hidden", action="store_true", help="names with a part _like_this")


def _graph(options: Namespace) -> int:
    from launcher.ros.draw.filter import Filter, Mode
    from launcher.ros.verb import graph_snapshot

    chosen = Filter(
        mode=Mode(options.mode),
        include=options.include,
        exclude=options.exclude,
        debug=options.debug_topics,
        hidden=options.hidden,
    )
    chosen.check()  # before any waiting
    before = _saved(options)
    if options.watch:
        with settled_observer(options) as observer:
            return _watch(observer, chosen, options)
    look = graph_snapshot(options)
    snapshot = chosen.apply(look.snapshot())
    if before is not None:
        return _diff(chosen.apply(before), snapshot, options)
    _show(snapshot, chosen, options, look.domain_id)
    return ExitCode.OK


def _saved(options: Namespace) -> TopicGraph | None:
    from launcher.ros.snapshot import diff

    return None if options.diff is None else diff.load(options.diff)


def _show(snapshot: TopicGraph, chosen: Filter, options: Namespace, domain_id: int) -> None:
    if options.json:
        from launcher.ros.snapshot.diff import to_document

        print_json(to_document(snapshot))
    elif options.mermaid:
        from launcher.ros.draw.mermaid import to_mermaid

        print(to_mermaid(snapshot, chosen.mode), end="")
    elif options.dot or options.svg or options.html:
        _draw(snapshot, chosen, options, domain_id)
    else:
        from launcher.ros.draw.tree import to_tree

        print(to_tree(snapshot, chosen.mode), end="")


def _draw(snapshot: TopicGraph, chosen: Filter, options: Namespace, domain_id: int) -> None:
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


def _diff(before: TopicGraph, after: TopicGraph, options: Namespace) -> int:
    from launcher.ros.snapshot.diff import difference

    lines = difference(before, after)
    if options.json:
        print_json(lines)
    else:
        for line in lines:
            print(line)
    return ExitCode.PROCESS_FAILED if lines else ExitCode.OK


def _watch(observer: Observer, chosen: Filter, options: Namespace) -> int:
    from launcher.ros.draw.tree import to_tree
    from launcher.ros.snapshot.diff import difference
    from launcher.ros.topics.streams import until_interrupted

    say: Callable[[str], None] = lambda text: print(text, flush=True)  # noqa: E731
    with until_interrupted():
        before = chosen.apply(observer.snapshot())
        say(to_tree(before, chosen.mode))
        while True:
            time.sleep(options.period)
            after = chosen.apply(observer.snapshot())
            for line in difference(before, after):
                say(f"{time.strftime('%H:%M:%S')} {line}")
            before = after
    return ExitCode.OK
