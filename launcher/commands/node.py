"""`node VERB ...`: which nodes there are, what they use, and which process each one is."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Sequence

from launcher.errors import ExitCode
from launcher.ros.verb import (
    Parser,
    add_verb,
    dispatch,
    domain_option,
    parser_of,
    print_json,
    seconds,
    settled_observer,
    warn,
)


def main(words: Sequence[str]) -> int:
    """Run one `node` command; the exit code."""
    return dispatch(build_parser(), _RUN, words)


def build_parser() -> Parser:
    """The options of every sub-verb."""
    parser, table = parser_of("node", "Look at nodes.")
    sub = add_verb(table, "list", "names of all nodes")
    sub.add_argument("-a", "--all", action="store_true", help="hidden ones as well")
    sub.add_argument("-c", "--count-nodes", action="store_true", help="only how many there are")
    sub = add_verb(table, "info", "what a node publishes, subscribes to and serves")
    sub.add_argument("node_name", metavar="NAME", help="full name of the node")
    sub.add_argument("--include-hidden", action="store_true", help="hidden names as well")
    sub = add_verb(table, "ps", "which process each node is, and whether it answers")
    sub.add_argument("-a", "--all", action="store_true", help="hidden nodes as well")
    sub.add_argument(
        "--patience", type=seconds, default=1.0, metavar="S", help="for the answer of a node (1)"
    )
    return parser


def _list(options: Namespace) -> int:
    from launcher.ros import nodes
    from launcher.ros.verb import graph_snapshot

    names = nodes.visible_names(graph_snapshot(options).nodes, hidden=options.all)
    if options.json:
        print_json([{"name": name, "count": names.count(name)} for name in sorted(set(names))])
        return ExitCode.OK
    if len(set(names)) < len(names):
        warn(nodes.SHARED_NAME)
    for line in [len(names)] if options.count_nodes else names:
        print(line)
    return ExitCode.OK


def _info(options: Namespace) -> int:
    from launcher.ros import nodes
    from launcher.ros.verb import graph_snapshot

    name, look = options.node_name, graph_snapshot(options)
    found = nodes.sections(look, name, hidden=options.include_hidden)
    count = look.nodes.count(name)
    if options.json:
        print_json({"name": name, **{title: dict(entries) for title, entries in found.items()}})
        return ExitCode.OK
    if count > 1:
        warn(
            f'There are {count} nodes in the graph with the exact name "{name}". '
            "You are seeing information about only one of them."
        )
    print("\n".join(nodes.info_lines(name, found)))
    return ExitCode.OK


def _ps(options: Namespace) -> int:
    from dataclasses import asdict

    from launcher.ros.discovery.graph_socket import snapshot_of_run
    from launcher.ros.nodes import rows, to_table, with_ghosts
    from launcher.ros.services import ServiceCaller

    # asked before we are in the graph ourselves: it does not answer while somebody comes
    look = None if options.no_observer else snapshot_of_run(domain_option(options))
    with settled_observer(options) as observer, ServiceCaller(observer) as caller:
        found = rows(caller, hidden=options.all, patience_s=options.patience)
    if look is not None:
        found = with_ghosts(found, look.ghosts)
    if options.json:
        print_json([asdict(row) for row in found])
    else:
        print(to_table(found))
    return ExitCode.OK


_RUN: dict[str, Callable[[Namespace], int]] = {"list": _list, "info": _info, "ps": _ps}
