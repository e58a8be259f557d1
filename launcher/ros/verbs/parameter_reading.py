"""`param list` and `param get`, of one node and of all nodes."""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from launcher.base.command_line import Parsed
from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.verb import (
    GraphAccess,
    observing,
    settled_observer,
    show,
    show_lines,
    spin_time_s,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.service_caller import ServiceCaller
    from launcher.ros.snapshot.ros_graph import GraphSnapshot


def _answer_s(options: Parsed) -> float | None:
    timeout: float | None = options.service_timeout
    return options.timeout if timeout is None else timeout


def _apply_timeout(options: Parsed) -> None:
    """The graph need not be complete later than the timeout."""
    if options.timeout is not None and options.spin_time is None:
        options.spin_time = options.timeout


@contextlib.contextmanager
def asking(options: Parsed) -> Iterator[tuple[ServiceCaller, str]]:
    """A caller, and the full name of the node that the options name."""
    from launcher.ros.service_caller import ServiceCaller, require_node

    node, started = full_name(options.node_name), time.monotonic()
    _apply_timeout(options)
    services = {f"{node}/list_parameters", f"{node}/get_parameters"}

    def is_known(graph: GraphSnapshot) -> bool:
        # a participant announces its services before its nodes
        return node in graph.nodes and services <= graph.service_types().keys()

    with (
        observing(GraphAccess.of(options), is_known) as observer,
        ServiceCaller(observer, answer_s=_answer_s(options)) as caller,
    ):
        from launcher.ros.parameters import prepare

        prepare(caller, node)
        until_s = started + (options.timeout or 0.0)
        found = require_node(observer, options.node_name, spin_time_s(options), until_s)
        yield caller, found


@contextlib.contextmanager
def _asking_all(options: Parsed, service: str) -> Iterator[tuple[ServiceCaller, list[str]]]:
    """A caller, and the nodes with this service, sorted."""
    from launcher.ros.node_tables import visible_names
    from launcher.ros.service_caller import ServiceCaller

    _apply_timeout(options)
    with (
        settled_observer(options) as observer,
        ServiceCaller(observer, answer_s=_answer_s(options)) as caller,
    ):
        names = set(visible_names(observer.node_names(), hidden=options.include_hidden_nodes))
        services = dict(observer.node.get_service_names_and_types())
        yield caller, sorted(name for name in names if f"{name}/{service}" in services)


def _late(service: str, node: str, caller: ServiceCaller) -> str:
    """The sentence of ros2cli."""
    limit = f"(timeout: {caller.answer_s}s)"
    return f"Timed out waiting for {service} response from node {node} {limit}"


def _list_document(found: dict[str, list[dict[str, str]]]) -> dict[str, Any]:
    return {"nodes": [{"name": node, "parameters": names} for node, names in found.items()]}


def _list_lines(found: list[dict[str, str]]) -> Iterator[str]:
    for one in found:
        kind = f" (type: {one['type']})" if "type" in one else ""
        yield f"  {one['name']}{kind}"


def _selected(
    caller: ServiceCaller, node: str, names: list[str], options: Parsed
) -> list[dict[str, str]]:
    """Those of the names that are wanted, with their types if those are asked for."""
    from launcher.ros import parameter_values, parameters

    if options.filter is not None:
        names = [name for name in names if options.filter.match(name)]
    if not options.param_type or not names:
        return [{"name": name} for name in names]
    types = parameters.declared_types(caller, node, names)
    # one may have been undeclared meanwhile
    return [
        {"name": name, "type": parameter_values.type_name(types[name])}
        for name in names
        if name in types
    ]


def show_names(options: Parsed) -> int:
    """`param list`."""
    if options.node_name is None:
        return _list_all(options)
    from launcher.ros import parameters

    with asking(options) as (caller, node):
        names = parameters.list_names(caller, node, list(options.param_prefixes))
        found = _selected(caller, node, names, options)
    return show(options, _list_document({node: found}), _list_lines(found))


def _list_all(options: Parsed) -> int:
    from rcl_interfaces.srv import ListParameters

    from launcher.ros.service_caller import NoAnswerError

    found: dict[str, list[dict[str, str]]] = {}
    code = ExitCode.OK
    service, request = "list_parameters", ListParameters.Request(prefixes=[*options.param_prefixes])
    with _asking_all(options, service) as (caller, nodes):
        for node, answer in caller.ask_each(ListParameters, nodes, service, request):
            problem = _late(service, node, caller)
            if answer is not None:
                try:
                    found[node] = _selected(caller, node, sorted(answer.result.names), options)
                except NoAnswerError as error:
                    problem = error.message
            if node not in found:
                warn(problem)
                code = ExitCode.PROCESS_FAILED
            elif found[node]:
                show_lines(options, [f"{node}:", *_list_lines(found[node])])
    show(options, _list_document(found), ())
    return code


def show_values(options: Parsed) -> int:
    """`param get`."""
    from launcher.ros import parameter_values, parameters

    names = options.parameter_names
    if options.node_name is None:
        return _get_everywhere(options, names[0])
    with asking(options) as (caller, node):
        found = parameters.known_values(caller, node, names)
        if len(names) == 1 and not found:
            parameters.require_names(caller, node, names)
        silent = [name for name in names if name not in found]
        known = parameters.list_names(caller, node) if silent else []
    absent = [name for name in silent if name not in known]
    found |= dict.fromkeys(set(silent) - set(absent), parameter_values.unset())
    rows = [parameter_values.document(name, found[name]) for name in names if name in found]
    document = {"node": node, "parameters": rows} if len(names) > 1 else {"node": node, **rows[0]}
    lines = (
        _value_lines(found[name], name if len(names) > 1 else None, options)
        for name in names
        if name in found
    )
    show(options, document, itertools.chain.from_iterable(lines))
    if absent:
        hints = [did_you_mean(name, known) for name in absent]
        listed = ", ".join(f"'{name}'" for name in absent)
        hint = next(filter(None, hints), f"parameters: {', '.join(known)}")
        raise VerbError(f"Parameter(s) {listed} not available on node", hint=hint)
    return ExitCode.OK


def _value_lines(value: Any, title: str | None, options: Parsed) -> list[str]:
    """A value, after what it belongs to if there are several."""
    from launcher.ros.parameter_values import value_text

    text = value_text(value, hide_type=options.hide_type)
    if title is None:
        return [text]
    return [f"{title}: {text}"] if options.hide_type else [f"{title}:", f"  {text}"]


def _get_everywhere(options: Parsed, name: str) -> int:
    """The parameter of each node that has it."""
    from rcl_interfaces.srv import GetParameters

    from launcher.ros import parameter_values

    rows = []
    code = ExitCode.OK
    service, request = "get_parameters", GetParameters.Request(names=[name])
    with _asking_all(options, service) as (caller, nodes):
        for node, answer in caller.ask_each(GetParameters, nodes, service, request):
            if answer is None:
                warn(f"{node}: Error: {_late(service, node, caller)}")
                code = ExitCode.PROCESS_FAILED
                continue
            for value in filter(lambda value: value.type, answer.values):
                rows.append({"node": node, **parameter_values.document(name, value)})
                show_lines(options, _value_lines(value, node, options))
    if not rows:
        show_lines(options, [f"Parameter '{name}' not set on any node"])
        if (node := full_name(name)) in nodes:
            warn(f"hint: '{node}' is a node: param list {node}")
    show(options, {"parameters": rows}, ())
    return code
