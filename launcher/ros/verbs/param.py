"""`param VERB ...`: list, get and set parameters of running nodes."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Mapping
from typing import Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import option
from launcher.base.verb_table import VERBS
from launcher.ros.verb import dispatch, ros_command, seconds, show, warn
from launcher.ros.verbs.parameter_reading import asking, show_names, show_values

NODE = option("NODE", name="node_name")
ANY_NODE = option("[NODE]", name="node_name")
PARAMETER = option("PARAMETER", name="parameter_name")
HIDDEN = option("--include-hidden-nodes", "hidden nodes as well")
TIMEOUTS = (
    option(
        "--timeout S",
        "wait S seconds for the node, and as long for each answer (default: until the graph is "
        "complete, and 5 for an answer)",
        seconds,
    ),
    option("--service-timeout S", "wait S seconds for each answer, whatever --timeout is", seconds),
)


def _pattern(word: str) -> re.Pattern[str]:
    """A regular expression; ValueError."""
    try:
        return re.compile(word)
    except re.error as error:
        raise ValueError(f"'{word}' is not a regular expression: {error}") from None


def _set(options: Parsed) -> int:
    from launcher.ros import parameter_values, parameters

    words = dict(zip(options.pairs[::2], options.pairs[1::2], strict=True))
    with asking(options) as (caller, node):
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
            result = parameters.named(
                parameters.set_atomically(caller, node, messages),
                [name for name in words if name not in types],
            )
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

    with asking(options) as (caller, node):
        result = parameters.delete(caller, node, options.parameter_name)
    code = _report(options, result, "Deleted parameter successfully", "Deleting parameter")
    return _show_results(options, node, {options.parameter_name: result}, code)


def _describe(options: Parsed) -> int:
    from launcher.ros import parameter_values, parameters
    from launcher.ros.messages.to_yaml import to_plain

    with asking(options) as (caller, node):
        found = parameters.describe(caller, node, options.parameter_names)
    documents = [to_plain(descriptor) for descriptor in found]
    named = [{**one, "type": parameter_values.type_name(one["type"])} for one in documents]
    lines = (parameters.descriptor_lines(descriptor) for descriptor in found)
    document = {"node": node, "parameters": named}
    return show(options, document, itertools.chain.from_iterable(lines))


def _dump(options: Parsed) -> int:
    from launcher.base.model.parameter_text import file_text
    from launcher.ros import parameter_documents, parameter_values, parameters

    with asking(options) as (caller, node):
        found = parameters.values_of(caller, node, parameters.list_names(caller, node))
    values = {
        name: parameter_values.plain_value(value) for name, value in found.items() if value.type
    }
    rows = [parameter_values.document(name, value) for name, value in found.items() if value.type]
    file = parameter_documents.dump_document(node, values)
    return show(options, {"node": node, "parameters": rows}, [file_text(file)])


def _load(options: Parsed) -> int:
    from launcher.ros import parameter_documents, parameter_values, parameters

    with asking(options) as (caller, node):
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
            show_names,
            ANY_NODE,
            option("--filter REGEX", "only parameters whose name begins with a match", _pattern),
            HIDDEN,
            option(
                "--param-prefixes PREFIX ...", "only parameters below these prefixes", default=()
            ),
            option("--param-type", "show their types"),
            *TIMEOUTS,
        ),
        ros_command(
            "param get",
            "print the values of parameters, or of one parameter of all nodes",
            show_values,
            ANY_NODE,
            option("PARAMETER ...", name="parameter_names"),
            HIDDEN,
            option("--hide-type", "print the value only"),
            *TIMEOUTS,
        ),
        ros_command(
            "param set",
            "set parameters",
            _set,
            NODE,
            option("PARAMETER VALUE ...", name="pairs"),
            HIDDEN,
            option("--atomic", "set all or none"),
            *TIMEOUTS,
        ),
        ros_command(
            "param delete",
            "delete a parameter, where the node allows it",
            _delete,
            NODE,
            PARAMETER,
            HIDDEN,
            *TIMEOUTS,
        ),
        ros_command(
            "param describe",
            "show the type, the description and the limits of parameters",
            _describe,
            NODE,
            option("PARAMETER ...", name="parameter_names"),
            HIDDEN,
            *TIMEOUTS,
        ),
        ros_command(
            "param dump",
            "print the parameters of a node as a file",
            _dump,
            NODE,
            HIDDEN,
            *TIMEOUTS,
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
            *TIMEOUTS,
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
