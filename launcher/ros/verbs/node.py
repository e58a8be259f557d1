"""`node VERB ...`: list and inspect nodes, and find their processes."""

from __future__ import annotations

import functools

from launcher.base.command_line import Command, Parsed
from launcher.base.model.ros_names import full_name
from launcher.base.option import option
from launcher.base.verb_table import VERBS
from launcher.ros.verb import (
    dispatch,
    domain_option,
    graph_snapshot,
    ros_command,
    seconds,
    settled_observer,
    show,
    typed,
    warn,
)

ALL = option("-a, --all", "hidden nodes as well")


def _list(options: Parsed) -> int:
    from launcher.ros import node_tables

    names = node_tables.visible_names(graph_snapshot(options).nodes, hidden=options.all)
    if len(set(names)) < len(names) and not (options.json or options.count_nodes):
        warn(node_tables.SHARED_NAME)
    document = [{"name": name, "count": names.count(name)} for name in sorted(set(names))]
    return show(options, {"nodes": document}, [len(names)] if options.count_nodes else names)


def _info(options: Parsed) -> int:
    from launcher.ros import node_tables

    name, graph = full_name(options.node_name), graph_snapshot(options)
    found = node_tables.sections(graph, name, hidden=options.include_hidden)
    count = graph.nodes.count(name)
    if count > 1 and not options.json:
        warn(
            f'There are {count} nodes in the graph with the exact name "{name}". '
            "You are seeing information about only one of them."
        )
    sections = {title.lower().replace(" ", "_"): typed(one) for title, one in found.items()}
    document = {"name": name, **sections}
    return show(options, document, node_tables.info_lines(name, found))


def _ps(options: Parsed) -> int:
    from launcher.ros.discovery.graph_socket import snapshot_of_run
    from launcher.ros.node_tables import rows, to_table, with_ghosts
    from launcher.ros.service_caller import ServiceCaller

    # Read before our own participant is created: the bridge does not answer while one is new.
    before = None if options.no_observer else snapshot_of_run(domain_option(options))
    with settled_observer(options) as observer, ServiceCaller(observer) as caller:
        found = rows(caller, hidden=options.all, timeout_s=options.answer_timeout)
    if before is not None:
        found = with_ghosts(found, before.ghosts)
    return show(options, {"nodes": [row.document() for row in found]}, [to_table(found)])


COMMAND = Command(
    "node",
    VERBS["node"],
    commands=(
        ros_command(
            "node list",
            "list nodes",
            _list,
            ALL,
            option("-c, --count-nodes", "print only the number of nodes"),
        ),
        ros_command(
            "node info",
            "show the publishers, subscriptions and services of a node",
            _info,
            option("NAME", "name of the node", name="node_name"),
            option("--include-hidden", "hidden names as well"),
        ),
        ros_command(
            "node ps",
            "show the process of each node, and whether the node answers",
            _ps,
            ALL,
            option(
                "--answer-timeout S", "wait up to S seconds for each node to answer", seconds, 1.0
            ),
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
