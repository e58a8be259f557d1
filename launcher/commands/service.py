"""`service VERB ...`: which services there are, and calling them."""

from __future__ import annotations

import json
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from launcher.errors import ExitCode
from launcher.ros.verb import (
    Parser,
    add_verb,
    dispatch,
    observing,
    parser_of,
    print_json,
    require_rate,
    seconds,
    spin_time_s,
)

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.services import ServiceCaller

_CONNECT_S = 3.0  # longest time between the discovery of a service and its being ready


def main(words: Sequence[str]) -> int:
    """Run one `service` command; the exit code."""
    return dispatch(build_parser(), _RUN, words)


def build_parser() -> Parser:
    """The options of every sub-verb."""
    parser, table = parser_of("service", "Look at and call services.")
    sub = add_verb(table, "list", "names of all services")
    sub.add_argument("-t", "--show-types", action="store_true", help="their types as well")
    sub.add_argument("-c", "--count-services", action="store_true", help="only how many")
    sub.add_argument("--include-hidden-services", action="store_true", help="hidden ones, too")
    sub = add_verb(table, "type", "type of a service")
    sub.add_argument("service_name", metavar="NAME")
    sub = add_verb(table, "find", "services of a type")
    sub.add_argument("service_type", metavar="TYPE")
    sub.add_argument("-c", "--count-services", action="store_true", help="only how many")
    sub.add_argument("--include-hidden-services", action="store_true", help="hidden ones, too")
    _add_call(table)
    return parser


def _add_call(table: Any) -> None:
    sub = add_verb(table, "call", "call a service")
    sub.add_argument("service_name", metavar="NAME")
    sub.add_argument("service_type", metavar="TYPE")
    sub.add_argument("values", nargs="?", default="", metavar="YAML", help="of the request")
    sub.add_argument("--stdin", action="store_true", help="read the YAML from stdin")
    sub.add_argument("-r", "--rate", type=float, metavar="HZ", help="again and again")
    sub.add_argument(
        "--timeout", type=seconds, default=30.0, metavar="S", help="longest wait for an answer (30)"
    )


def _services(options: Namespace, *, hidden: bool) -> dict[str, list[str]]:
    from launcher.ros.snapshot.graph import is_hidden
    from launcher.ros.verb import graph_snapshot

    found = graph_snapshot(options).service_types()
    return {name: types for name, types in found.items() if hidden or not is_hidden(name)}


def _list(options: Namespace) -> int:
    found = _services(options, hidden=options.include_hidden_services)
    if options.json:
        print_json([{"name": name, "types": types} for name, types in found.items()])
    elif options.count_services:
        print(len(found))
    else:
        for name, types in found.items():
            print(f"{name} [{', '.join(types)}]" if options.show_types else name)
    return ExitCode.OK


def _type(options: Namespace) -> int:
    types = _services(options, hidden=True).get(options.service_name, [])
    if options.json:
        print_json({"name": options.service_name, "types": types})
    else:
        for type_name in types:
            print(type_name)
    return ExitCode.OK if types else ExitCode.PROCESS_FAILED


def _find(options: Namespace) -> int:
    from launcher.ros.messages.interfaces import full_type, warn_if_unknown

    known = _services(options, hidden=options.include_hidden_services)
    kind = full_type(options.service_type, "srv")
    found = [name for name, types in known.items() if kind in types]
    if not found:
        warn_if_unknown(kind)
    if options.json:
        print_json(found)
    else:
        for line in [len(found)] if options.count_services else found:
            print(line)
    return ExitCode.OK


def _call(options: Namespace) -> int:
    from launcher.ros.messages.from_yaml import fill, parse
    from launcher.ros.messages.interfaces import load
    from launcher.ros.services import ServiceCaller

    if options.rate is not None:
        require_rate(options.rate)
    kind = load(options.service_type, "srv", "The passed service type is invalid")
    request = kind.Request()
    fill(request, parse(sys.stdin.read() if options.stdin else options.values))
    name = _full(options.service_name)
    with (
        observing(options, lambda look: name in look.service_types()) as observer,
        ServiceCaller(observer) as caller,
    ):
        _await_service(caller, kind, options)
        while True:
            started = time.monotonic()
            _call_once(caller, kind, request, options)
            if options.rate is None:
                return ExitCode.OK
            time.sleep(max(0.0, started + 1.0 / options.rate - time.monotonic()))


def _await_service(caller: ServiceCaller, kind: Any, options: Namespace) -> None:
    """Wait for the service; VerbError if it is there with another type."""
    from launcher.ros.errors import VerbError

    caller.load(kind)
    name = _full(options.service_name)
    types = _offered(caller.observer, name, spin_time_s(options))
    if types and f"{kind.__module__.split('.')[0]}/srv/{kind.__name__}" not in types:
        raise VerbError(
            f"service '{name}' has the type {', '.join(types)}, not {options.service_type}"
        )
    client = caller.client(kind, options.service_name)
    if types and caller.wait_for(client, _CONNECT_S):
        return
    print("waiting for service to become available...", flush=True)
    while not caller.wait_for(client, 1.0):
        pass


def _full(name: str) -> str:
    return "/" + name.lstrip("/")


def _offered(observer: Observer, name: str, spin_time_s: float) -> list[str]:
    """The types of a service; asked before our client is in the graph with the one it wants."""
    from launcher.ros.discovery.completeness import settle

    if (look := observer.seen_ahead()) is not None:
        return look.service_types().get(name, [])

    def known() -> list[str]:
        types: list[str] = dict(observer.node.get_service_names_and_types()).get(name, [])
        return types

    settle(observer, spin_time_s, enough=known)
    return known()


def _call_once(caller: ServiceCaller, kind: Any, request: Any, options: Namespace) -> None:
    from launcher.ros.messages.to_yaml import to_json_plain, to_plain

    if not options.json:
        print(f"requester: making request: {request!r}\n", flush=True)
    answer = caller.call(kind, options.service_name, request, options.timeout)
    if options.json:
        print(json.dumps(to_json_plain(to_plain(answer)), ensure_ascii=False), flush=True)
    else:
        print(f"response:\n{answer!r}\n", flush=True)


_RUN: dict[str, Callable[[Namespace], int]] = {
    "list": _list,
    "type": _type,
    "find": _find,
    "call": _call,
}
