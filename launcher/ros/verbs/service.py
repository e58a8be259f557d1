"""`service VERB ...`: list and call services."""

from __future__ import annotations

import functools
import math
import sys
import time
from typing import TYPE_CHECKING

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.option import JSON_LINES, number, option
from launcher.base.verb_table import VERBS
from launcher.posix.json_output import print_line
from launcher.ros.verb import (
    GraphAccess,
    dispatch,
    graph_snapshot,
    observing,
    require_rate,
    ros_command,
    seconds,
    show,
    show_typed,
    spin_time_s,
    standard_input,
    to_json_plain,
    warn,
)
from launcher.ros.verbs.listening import QOS, STYLE, qos_options, style

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

    from launcher.ros.service_caller import ServiceCaller
    from launcher.ros.snapshot.ros_graph import GraphSnapshot

_CONNECT_S = 3.0  # longest time between the discovery of a service and its being ready
_ANSWER_S = 30.0


NAME = option("NAME", name="service_name")
TYPE = option("TYPE", name="service_type")
COUNT = option("-c, --count-services", "print only their number")
HIDDEN = option("--include-hidden-services", "hidden services as well")


def _services(options: Parsed, *, hidden: bool) -> dict[str, list[str]]:
    from launcher.ros.snapshot.ros_graph import is_hidden

    found = graph_snapshot(options).service_types()
    return {name: types for name, types in found.items() if hidden or not is_hidden(name)}


def _list(options: Parsed) -> int:
    found = _services(options, hidden=options.include_hidden_services)
    return show_typed(
        options,
        "services",
        found,
        only_count=options.count_services,
        with_types=options.show_types,
    )


def _type(options: Parsed) -> int:
    types = _services(options, hidden=True).get(full_name(options.service_name), [])
    show(options, {"name": full_name(options.service_name), "types": types}, types)
    return ExitCode.OK if types else ExitCode.PROCESS_FAILED


def _find(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import of_type

    known = _services(options, hidden=options.include_hidden_services)
    found = of_type(known, options.service_type, "srv")
    return show_typed(options, "services", found, only_count=options.count_services)


def _info(options: Parsed) -> int:
    from launcher.base.ros_errors import VerbError, did_you_mean
    from launcher.ros import service_endpoints
    from launcher.ros.snapshot.ros_graph import is_hidden

    graph, name = graph_snapshot(options), full_name(options.service_name)
    known = graph.service_types()
    if name not in known:
        hint = did_you_mean(name, [one for one in known if not is_hidden(one)])
        raise VerbError(f"Unknown service '{options.service_name}'", hint=hint)
    found = service_endpoints.endpoints(graph, name)
    document = {
        "name": name,
        "types": known[name],
        "clients": [one.node for one in graph.clients(name)],
        "servers": [one.node for one in graph.servers(name)],
        "endpoints": [one.document() for one in found],
    }
    lines = service_endpoints.info_lines(found, known[name], verbose=options.verbose)
    return show(options, document, lines)


def _echo(options: Parsed) -> int:
    from launcher.ros.verbs.service_events import EventWriter, ServiceEchoOptions, echo

    return echo(
        ServiceEchoOptions(
            access=GraphAccess.of(options),
            service=options.service_name,
            type=options.service_type,
            writer=EventWriter(style=style(options), csv=options.csv, json=options.json),
            qos=qos_options(options),
            timeout_s=options.timeout,
        )
    )


def _call(options: Parsed) -> int:
    from launcher.ros.messages.from_yaml import fill, parse, stamp_all
    from launcher.ros.messages.interfaces import load
    from launcher.ros.service_caller import ServiceCaller
    from launcher.ros.verbs.streams import until_interrupted

    if options.rate is not None:
        require_rate(options.rate)
    kind = load(options.service_type, "srv", "The passed service type is invalid")
    request = kind.Request()
    stamps = fill(request, parse(standard_input() if options.stdin else options.values))
    name = full_name(options.service_name)
    with (
        observing(GraphAccess.of(options), lambda graph: name in graph.service_types()) as observer,
        ServiceCaller(observer) as caller,
    ):
        _await_service(caller, kind, options)
        with until_interrupted(is_end=options.rate is not None):
            while True:
                started = time.monotonic()
                stamp_all(stamps, observer.node.get_clock().now().to_msg())
                _call_once(caller, kind, request, options)
                if options.rate is None:
                    break
                time.sleep(max(0.0, started + 1.0 / options.rate - time.monotonic()))
    return ExitCode.OK


def _await_service(caller: ServiceCaller, kind: object, options: Parsed) -> None:
    """Wait for the service; VerbError if it has another type, or is not there in time."""
    from launcher.base.ros_errors import VerbError
    from launcher.ros.discovery.completeness import settled_graph
    from launcher.ros.messages.classes import type_name
    from launcher.ros.service_caller import NoAnswerError

    deadline = time.monotonic() + (math.inf if options.timeout is None else options.timeout)
    caller.load(kind)
    name = full_name(options.service_name)
    # read before our own client adds the type that it requests
    graph = settled_graph(
        caller.observer, spin_time_s(options), lambda graph: name in graph.service_types()
    )
    types = graph.service_types().get(name, [])
    if types and type_name(kind) not in types:
        raise VerbError(
            f"service '{name}' has the type {', '.join(types)}, not {options.service_type}"
        )
    profile = _profile(options)
    client = caller.client(kind, options.service_name, profile)
    if types and caller.wait_for(client, _CONNECT_S):
        return
    # With --json, standard output has answers only.
    stream = sys.stderr if options.json else sys.stdout
    print("waiting for service to become available...", file=stream, flush=True)
    if text := _mismatch(graph, name, type_name(kind), profile):
        warn(text)
    if not caller.wait_for(client, deadline - time.monotonic()):
        is_there = f"service '{name}' is there, but its QoS does not match: waited"
        why = is_there if text else f"service '{name}' is not available after"
        raise NoAnswerError(f"{why} {options.timeout:g} s")


def _mismatch(graph: GraphSnapshot, name: str, type_name: str, profile: QoSProfile) -> str:
    """Why no server matches a client with this profile; empty if none is there, or one may."""
    from launcher.ros.service_endpoints import endpoints
    from launcher.ros.snapshot.qos_matching import REQUESTS, RESPONSES, explain, mismatches
    from launcher.ros.snapshot.ros_graph import Direction
    from launcher.ros.topics.qos import endpoint_of

    servers = [one for one in endpoints(graph, name) if not one.is_client]
    texts = []
    for direction, roles, theirs in (
        (Direction.PUBLISHER, REQUESTS, [one.reader for one in servers]),
        (Direction.SUBSCRIPTION, RESPONSES, [one.writer for one in servers if one.writer]),
    ):
        own = endpoint_of(profile, direction, name, type_name, node="this command")
        pairs = [own, *(info.endpoint() for info in theirs)]
        texts += [explain(pairs, roles)] if mismatches(pairs) else []
    return "\n".join(texts)


def _profile(options: Parsed) -> QoSProfile:
    from rclpy.qos import qos_profile_services_default

    from launcher.ros.topics.qos import from_options

    return from_options(qos_options(options), qos_profile_services_default)


def _call_once(caller: ServiceCaller, kind: object, request: object, options: Parsed) -> None:
    from launcher.ros.messages.to_yaml import to_plain
    from launcher.ros.service_caller import NoAnswerError, silence

    if not options.json:
        print(f"requester: making request: {request!r}\n", flush=True)
    name, limit_s = options.service_name, options.timeout
    limit_s = _ANSWER_S if limit_s is None else limit_s
    future = caller.start(kind, name, request)
    caller.wait_until_done([future], limit_s)
    if not future.done():
        raise NoAnswerError(
            f"Timed out waiting for response from service {name} (timeout: {limit_s}s)",
            hint=silence(name, limit_s).hint,
        )
    answer = future.result()
    if options.json:
        print_line({"response": to_json_plain(to_plain(answer))})
    else:
        print(f"response:\n{answer!r}\n", flush=True)


COMMAND = Command(
    "service",
    VERBS["service"],
    options=(HIDDEN,),
    commands=(
        ros_command(
            "service list",
            "list services",
            _list,
            option("-t, --show-types", "show their types"),
            COUNT,
            HIDDEN,
        ),
        ros_command("service type", "print the type of a service", _type, NAME),
        ros_command(
            "service info",
            "show the type of a service, and how many use it",
            _info,
            NAME,
            option("-v, --verbose", "show the clients and servers with their QoS"),
        ),
        ros_command(
            "service echo",
            "print the requests and responses of a service that has introspection",
            _echo,
            NAME,
            option("[TYPE]", name="service_type"),
            option("--timeout S", "end after S seconds", seconds),
            *STYLE,
            groups=QOS,
            json=JSON_LINES,
        ),
        ros_command("service find", "list the services of a type", _find, TYPE, COUNT, HIDDEN),
        ros_command(
            "service call",
            "call a service",
            _call,
            NAME,
            TYPE,
            option("[YAML]", "the request", default="", name="values"),
            option("--stdin", "read the YAML from stdin"),
            option("-r, --rate HZ", "repeat the call at this rate", number),
            option(
                "--timeout S",
                "wait S seconds for the service, and as long for each response "
                "(default: without end for the service, 30 for a response)",
                seconds,
            ),
            groups=QOS,
            exclusive=(("values", "stdin"),),
            json=JSON_LINES,
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
