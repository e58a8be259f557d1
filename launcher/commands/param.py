"""`param VERB ...`: parameters of running nodes."""

from __future__ import annotations

import contextlib
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from launcher.errors import ExitCode, UsageError
from launcher.ros.verb import (
    Parser,
    add_verb,
    dispatch,
    observing,
    parser_of,
    print_json,
    settled_observer,
    spin_time_s,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.services import ServiceCaller
    from launcher.ros.snapshot.graph import GraphSnapshot


def main(words: Sequence[str]) -> int:
    """Run one `param` command; the exit code."""
    return dispatch(build_parser(), _RUN, words)


def build_parser() -> Parser:
    """The options of every sub-verb."""
    parser, table = parser_of("param", "Look at and set parameters.")
    sub = _add(table, "list", "names of parameters", node_count="?")
    sub.add_argument("--param-prefixes", nargs="+", default=[], metavar="PREFIX")
    sub.add_argument("--param-type", action="store_true", help="their types as well")
    sub = _add(table, "get", "value of a parameter")
    sub.add_argument("parameter_name", metavar="PARAMETER")
    sub.add_argument("--hide-type", action="store_true", help="the value alone")
    sub = _add(table, "set", "set parameters")
    sub.add_argument("pairs", nargs="+", metavar="PARAMETER VALUE")
    sub.add_argument("--atomic", action="store_true", help="all or none")
    sub = _add(table, "describe", "type, description and limits of parameters")
    sub.add_argument("parameter_names", nargs="+", metavar="PARAMETER")
    _add(table, "dump", "all parameters of a node as a parameter file")
    sub = _add(table, "load", "set the parameters of a node from a parameter file")
    sub.add_argument("parameter_file", metavar="FILE")
    sub.add_argument("--use-wildcard", action="store_true", help="those under /** as well")
    return parser


def _add(table: Any, name: str, help_text: str, node_count: str | None = None) -> Parser:
    sub = add_verb(table, name, help_text)
    sub.add_argument("node_name", nargs=node_count, metavar="NODE")
    sub.add_argument("--include-hidden-nodes", action="store_true", help="hidden ones as well")
    return sub


@contextlib.contextmanager
def _asking(options: Namespace) -> Iterator[tuple[ServiceCaller, str]]:
    """A caller, and the full name of the node that the options name."""
    from launcher.ros.services import ServiceCaller, full_node, require_node

    node = full_node(options.node_name)
    services = {f"{node}/list_parameters", f"{node}/get_parameters"}

    def is_known(look: GraphSnapshot) -> bool:
        # a participant announces its services before it names its nodes
        return node in look.nodes and services <= look.service_types().keys()

    with (
        observing(options, is_known) as observer,
        ServiceCaller(observer) as caller,
    ):
        from launcher.ros.parameters import prepare

        prepare(caller, node)
        yield caller, require_node(observer, options.node_name, spin_time_s(options))


def _list(options: Namespace) -> int:
    if options.node_name is None:
        return _list_all(options)
    with _asking(options) as (caller, node):
        names = _names(caller, node, options)
    if options.json:
        print_json({node: names})
        return ExitCode.OK
    for name in names:
        print(f"  {name}")
    return ExitCode.OK


def _names(caller: ServiceCaller, node: str, options: Namespace) -> list[str]:
    from launcher.ros import parameters

    names = parameters.list_names(caller, node, options.param_prefixes)
    if not options.param_type or not names:
        return names
    types = parameters.declared_types(caller, node, names)
    return [f"{name} (type: {parameters.type_name(types[name])})" for name in names]


def _list_all(options: Namespace) -> int:
    from launcher.ros.nodes import visible_names
    from launcher.ros.services import NoAnswerError, ServiceCaller

    found: dict[str, list[str]] = {}
    code = ExitCode.OK
    with settled_observer(options) as observer, ServiceCaller(observer) as caller:
        names = set(visible_names(observer.node_names(), hidden=options.include_hidden_nodes))
        services = dict(observer.node.get_service_names_and_types())
        for node in sorted(n for n in names if f"{n}/list_parameters" in services):
            try:
                found[node] = _names(caller, node, options)
            except NoAnswerError as error:
                warn(f"Exception while calling service of node '{node}': {error.message}")
                code = ExitCode.PROCESS_FAILED
    if options.json:
        print_json(found)
        return code
    for node, parameters in found.items():
        print(f"{node}:")
        for name in parameters:
            print(f"  {name}")
    return code


def _get(options: Namespace) -> int:
    from launcher.ros import parameters

    name = options.parameter_name
    with _asking(options) as (caller, node):
        values = parameters.get(caller, node, [name])
        if not values:
            parameters.require_names(caller, node, [name])
    if not values:
        print("Parameter not set.")
        return ExitCode.OK
    if options.json:
        kind = parameters.type_name(values[0].type)
        print_json({"name": name, "type": kind, "value": parameters.plain_value(values[0])})
    else:
        print(parameters.value_text(values[0], hide_type=options.hide_type))
    return ExitCode.OK


def _set(options: Namespace) -> int:
    from launcher.ros import parameters

    if len(options.pairs) % 2:
        raise UsageError(
            f"a value is missing after '{options.pairs[-1]}'",
            hint="param set NODE PARAMETER VALUE [PARAMETER VALUE ...]",
        )
    words = dict(zip(options.pairs[::2], options.pairs[1::2], strict=True))
    with _asking(options) as (caller, node):
        types = parameters.declared_types(caller, node, list(words))
        messages = [
            parameters.typed_parameter(name, word, types.get(name, parameters.NOT_SET))
            for name, word in words.items()
        ]
        if options.atomic:
            result = parameters.set_atomically(caller, node, messages)
            return _say(result, "Set parameters atomically", "Setting parameters atomically")
        results = parameters.set_all(caller, node, messages)
    codes = [
        _say(result, f"{prefix}Set parameter", f"{prefix}Setting parameter")
        for name, result in zip(words, results, strict=True)
        for prefix in [f"{name}: " if len(words) > 1 else ""]
    ]
    return max(codes)


def _say(result: Any, done: str, failing: str) -> int:
    reason = f": {result.reason}" if result.reason else ""
    if result.successful:
        print(f"{done} successful{reason}")
        return ExitCode.OK
    warn(f"{failing} failed{reason}")
    return ExitCode.PROCESS_FAILED


def _describe(options: Namespace) -> int:
    from launcher.ros import parameters
    from launcher.ros.messages.to_yaml import to_plain

    with _asking(options) as (caller, node):
        found = parameters.describe(caller, node, options.parameter_names)
    if options.json:
        documents = [to_plain(descriptor) for descriptor in found]
        print_json([{**d, "type": parameters.type_name(d["type"])} for d in documents])
        return ExitCode.OK
    for descriptor in found:
        print("\n".join(parameters.descriptor_lines(descriptor)))
    return ExitCode.OK


def _dump(options: Namespace) -> int:
    from launcher.ros import parameters
    from launcher.ros.messages.to_yaml import dump

    with _asking(options) as (caller, node):
        names = parameters.list_names(caller, node)
        values = [parameters.plain_value(v) for v in parameters.get(caller, node, names)]
    document = parameters.dump_document(node, dict(zip(names, values, strict=True)))
    if options.json:
        print_json(document)
    else:
        print(dump(document, sort=True))
    return ExitCode.OK


def _load(options: Namespace) -> int:
    from launcher.ros import parameters

    with _asking(options) as (caller, node):
        values = parameters.file_values(
            options.parameter_file, node, use_wildcard=options.use_wildcard
        )
        types = parameters.declared_types(caller, node, list(values))
        messages = [
            parameters.parameter(name, value, types.get(name, parameters.NOT_SET))
            for name, value in values.items()
        ]
        results = parameters.set_all(caller, node, messages)
        declared = [name for name in values if name in types]
        # fewer, or none, if one of them has no value
        now = dict(zip(declared, parameters.get(caller, node, declared), strict=False))
    code = int(ExitCode.OK)
    for message, result in zip(messages, results, strict=True):
        said = _say(result, f"Set parameter {message.name}", f"Set parameter {message.name}")
        # a file from `param dump` has the read-only ones as well, and they are as it says
        code = max(code, said if now.get(message.name) != message.value else ExitCode.OK)
    return code


_RUN: dict[str, Callable[[Namespace], int]] = {
    "list": _list,
    "get": _get,
    "set": _set,
    "describe": _describe,
    "dump": _dump,
    "load": _load,
}
