"""`param VERB ...`: list, get and set parameters of running nodes."""

from __future__ import annotations

import contextlib
import functools
import itertools
import re
import time
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.option import option
from launcher.base.verb_table import VERBS
from launcher.ros.verb import (
    GraphAccess,
    dispatch,
    observing,
    ros_command,
    seconds,
    settled_observer,
    show,
    spin_time_s,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.service_caller import ServiceCaller
    from launcher.ros.snapshot.ros_graph import GraphSnapshot


NODE = option("NODE", name="node_name")
PARAMETER = option("PARAMETER", name="parameter_name")
HIDDEN = option("--include-hidden-nodes", "hidden nodes as well")
TIMEOUT = option(
    "--timeout S",
    "wait S seconds for the node, and as long for each answer (default: until the graph is "
    "complete, and 5 for an answer)",
    seconds,
)


def _pattern(word: str) -> re.Pattern[str]:
    """A regular expression; ValueError."""
    try:
        return re.compile(word)
    except re.error as error:
        raise ValueError(f"'{word}' is not a regular expression: {error}") from None


@contextlib.contextmanager
def _asking(options: Parsed) -> Iterator[tuple[ServiceCaller, str]]:
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
        ServiceCaller(observer, answer_s=options.timeout) as caller,
    ):
        from launcher.ros.parameters import prepare

        prepare(caller, node)
        until_s = started + (options.timeout or 0.0)
        found = require_node(observer, options.node_name, spin_time_s(options), until_s)
        yield caller, found


def _apply_timeout(options: Parsed) -> None:
    """The graph need not be complete later than the timeout."""
    if options.timeout is not None and options.spin_time is None:
        options.spin_time = options.timeout


def _list(options: Parsed) -> int:
    if options.node_name is None:
        return _list_all(options)
    with _asking(options) as (caller, node):
        found = _found(caller, node, options)
    return show(options, _list_document({node: found}), _list_lines(found))


def _list_document(found: dict[str, list[dict[str, str]]]) -> dict[str, Any]:
    return {"nodes": [{"name": node, "parameters": names} for node, names in found.items()]}


def _list_lines(found: list[dict[str, str]]) -> Iterator[str]:
    for one in found:
        kind = f" (type: {one['type']})" if "type" in one else ""
        yield f"  {one['name']}{kind}"


def _found(caller: ServiceCaller, node: str, options: Parsed) -> list[dict[str, str]]:
    """The names of its parameters, with their types if those are asked for."""
    from launcher.ros import parameter_values, parameters

    names = parameters.list_names(caller, node, list(options.param_prefixes))
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


def _list_all(options: Parsed) -> int:
    from launcher.ros.node_tables import visible_names
    from launcher.ros.service_caller import NoAnswerError, ServiceCaller

    found: dict[str, list[dict[str, str]]] = {}
    code = ExitCode.OK
    _apply_timeout(options)
    with (
        settled_observer(options) as observer,
        ServiceCaller(observer, answer_s=options.timeout) as caller,
    ):
        names = set(visible_names(observer.node_names(), hidden=options.include_hidden_nodes))
        services = dict(observer.node.get_service_names_and_types())
        for node in sorted(n for n in names if f"{n}/list_parameters" in services):
            try:
                found[node] = _found(caller, node, options)
            except NoAnswerError as error:
                warn(f"Exception while calling service of node '{node}': {error.message}")
                code = ExitCode.PROCESS_FAILED
    shown = {node: names for node, names in found.items() if names}
    lines = ([f"{node}:", *_list_lines(shown[node])] for node in shown)
    show(options, _list_document(found), itertools.chain.from_iterable(lines))
    return code


def _get(options: Parsed) -> int:
    from launcher.ros import parameter_values, parameters

    name = options.parameter_name
    with _asking(options) as (caller, node):
        values = parameters.get(caller, node, [name])
        if not values:
            parameters.require_names(caller, node, [name])
    value = values[0] if values else parameter_values.unset()
    text = parameter_values.value_text(value, hide_type=options.hide_type and bool(values))
    document = {"node": node, **parameter_values.document(name, value)}
    return show(options, document, [text])


def _set(options: Parsed) -> int:
    from launcher.ros import parameter_values, parameters

    words = dict(zip(options.pairs[::2], options.pairs[1::2], strict=True))
    with _asking(options) as (caller, node):
        if options.atomic:
            types = parameters.declared_types(
                caller, node, list(words), parameter_values.type_for_words
            )
            messages = [
                parameter_values.typed_parameter(
                    name, word, types.get(name, parameter_values.NOT_SET)
                )
                for name, word in words.items()
            ]
            result = parameters.set_atomically(caller, node, messages)
            done = "Set parameters atomically successful"
            code = _report(options, result, done, "Setting parameters atomically")
            return _show_results(options, node, dict.fromkeys(words, result), code)
        outcomes = parameters.set_values(caller, node, words, parameter_values.typed_parameter)
    results = {name: one.result for name, one in outcomes.items()}
    codes = [
        _report(options, one, f"{prefix}Set parameter successful", f"{prefix}Setting parameter")
        for name, one in results.items()
        for prefix in [f"{name}: " if len(words) > 1 else ""]
    ]
    return _show_results(options, node, results, max(codes))


def _report(options: Parsed, result: Any, done: str, failing: str) -> int:
    """Print what became of a request, a failure on stderr; the exit code."""
    reason = f": {result.reason}" if result.reason else ""
    if not result.successful:
        warn(f"{failing} failed{reason}")
        return ExitCode.PROCESS_FAILED
    if not options.json:
        print(f"{done}{reason}")
    return ExitCode.OK


def _show_results(options: Parsed, node: str, results: Mapping[str, Any], code: int) -> int:
    """Print the document of these requests, which `_report` has reported; the exit code."""
    found = [
        {"name": name, "done": one.successful, "reason": one.reason or None}
        for name, one in results.items()
    ]
    show(options, {"node": node, "parameters": found}, ())
    return code


def _delete(options: Parsed) -> int:
    from launcher.ros import parameters

    with _asking(options) as (caller, node):
        result = parameters.delete(caller, node, options.parameter_name)
    code = _report(options, result, "Deleted parameter successfully", "Deleting parameter")
    return _show_results(options, node, {options.parameter_name: result}, code)


def _describe(options: Parsed) -> int:
    from launcher.ros import parameter_values, parameters
    from launcher.ros.messages.to_yaml import to_plain

    with _asking(options) as (caller, node):
        found = parameters.describe(caller, node, options.parameter_names)
    documents = [to_plain(descriptor) for descriptor in found]
    named = [{**one, "type": parameter_values.type_name(one["type"])} for one in documents]
    lines = (parameters.descriptor_lines(descriptor) for descriptor in found)
    document = {"node": node, "parameters": named}
    return show(options, document, itertools.chain.from_iterable(lines))


def _dump(options: Parsed) -> int:
    from launcher.base.model.parameter_text import file_text
    from launcher.ros import parameter_documents, parameter_values, parameters

    with _asking(options) as (caller, node):
        found = parameters.values_of(caller, node, parameters.list_names(caller, node))
    values = {
        name: parameter_values.plain_value(value) for name, value in found.items() if value.type
    }
    rows = [parameter_values.document(name, value) for name, value in found.items() if value.type]
    file = parameter_documents.dump_document(node, values)
    return show(options, {"node": node, "parameters": rows}, [file_text(file)])


def _load(options: Parsed) -> int:
    from launcher.ros import parameter_documents, parameter_values, parameters

    with _asking(options) as (caller, node):
        values = parameter_documents.file_values(
            options.parameter_file, node, use_wildcard=not options.no_use_wildcard
        )
        outcomes = parameters.set_values(caller, node, values, parameter_values.written_parameter)
        refused = [name for name, one in outcomes.items() if not one.result.successful]
        now = parameters.values_of(caller, node, refused)
    code = int(ExitCode.OK)
    for name, (message, result) in outcomes.items():
        one = _report(options, result, f"Set parameter {name} successful", f"Set parameter {name}")
        # A file of `param dump` has read-only parameters, too; they already have its values.
        is_so = message is not None and name in now and now[name] == message.value
        code = max(code, ExitCode.OK if is_so else one)
    results = {name: one.result for name, one in outcomes.items()}
    return _show_results(options, node, results, code)


COMMAND = Command(
    "param",
    VERBS["param"],
    commands=(
        ros_command(
            "param list",
            "list parameters",
            _list,
            option("[NODE]", name="node_name"),
            option("--filter REGEX", "only parameters whose name begins with a match", _pattern),
            HIDDEN,
            option(
                "--param-prefixes PREFIX ...", "only parameters below these prefixes", default=()
            ),
            option("--param-type", "show their types"),
            TIMEOUT,
        ),
        ros_command(
            "param get",
            "print the value of a parameter",
            _get,
            NODE,
            PARAMETER,
            HIDDEN,
            option("--hide-type", "print the value only"),
            TIMEOUT,
        ),
        ros_command(
            "param set",
            "set parameters",
            _set,
            NODE,
            option("PARAMETER VALUE ...", name="pairs"),
            HIDDEN,
            option("--atomic", "set all or none"),
            TIMEOUT,
        ),
        ros_command(
            "param delete",
            "delete a parameter, where the node allows it",
            _delete,
            NODE,
            PARAMETER,
            HIDDEN,
            TIMEOUT,
        ),
        ros_command(
            "param describe",
            "show the type, the description and the limits of parameters",
            _describe,
            NODE,
            option("PARAMETER ...", name="parameter_names"),
            HIDDEN,
            TIMEOUT,
        ),
        ros_command(
            "param dump",
            "print the parameters of a node as a file",
            _dump,
            NODE,
            HIDDEN,
            TIMEOUT,
        ),
        ros_command(
            "param load",
            "set the parameters of a node from a file",
            _load,
            NODE,
            option("FILE", name="parameter_file"),
            HIDDEN,
            option("--no-use-wildcard", "only those below the full name of the node"),
            option("--use-wildcard", "ignored, for compatibility: wildcards are taken"),
            TIMEOUT,
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
