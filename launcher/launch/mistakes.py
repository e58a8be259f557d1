"""Further mistakes in a launch file and its arguments, besides the one that ended its evaluation.

They are searched for only after something has failed, so nothing that ROS 2 accepts is rejected.
Every mistake that is found here would also fail in a run that gets that far.
"""

from __future__ import annotations

import contextlib
import linecache
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

from launcher.base.errors import (
    LauncherError,
    LaunchFileError,
    SeveralErrors,
    UsageError,
)
from launcher.base.program import program
from launcher.base.text import did_you_mean, suggest
from launcher.base.verb_table import CONTROL_VERBS, VERBS
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.diagnostics.truth_values import near_choice
from launcher.language.frontends.locate import WordAfterFileError
from launcher.language.ros.node import Node
from launcher.language.substitution import (
    TextSubstitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.language.substitutions.configuration import LaunchConfiguration
from launcher.launch.known_names import KnownNames, known_names
from launcher.launch.plan.planner import make_plan
from launcher.packages.finder import find_executable
from launcher.posix.stdio import silence

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.actions.arguments import DeclareLaunchArgument
    from launcher.language.context import LaunchContext
    from launcher.language.description import LaunchDescription
    from launcher.language.diagnostics.origin import FileLine

Arguments = Sequence[tuple[str, str]]
MAX_MISTAKES = 20  # reported at once
_OF_LAUNCH_FILES = ("launch", "plan", "args", "smoke")  # verbs that take one
_KNOWN_BEFOREHAND = (TextSubstitution, LaunchConfiguration)


def together(
    errors: Iterable[LauncherError], fault: LaunchFileError | None = None
) -> LauncherError:
    """One error for all of them, each once; `fault`, which led to them, is its cause."""
    different = list({error.render(): error for error in errors}.values())[:MAX_MISTAKES]
    error = different[0] if len(different) == 1 else SeveralErrors(different)
    if fault is not None and error is not fault:  # else it has its own, which a traceback shows
        error.__cause__ = fault
    return error


def unknown_names(
    arguments: Arguments, known: KnownNames, declared: Iterable[str]
) -> tuple[list[LauncherError], list[str]]:
    """(errors about arguments that nothing uses, warnings of those that something may use)."""
    listed = f"known arguments: {', '.join(declared) or 'none'}; --lenient accepts any name"
    errors: list[LauncherError] = []
    warnings = []
    for name in dict(arguments):
        if known.has(name):
            continue
        message = f"unknown launch argument '{name}'"
        hint, doubt = _near(name, known) or listed, known.doubt(name)
        if doubt is None:
            errors.append(UsageError(message, hint=hint))
        else:
            warnings.append(f"{message}, {doubt}; {hint}")
    return errors, warnings


def _near(name: str, known: KnownNames) -> str | None:
    return did_you_mean(name, sorted(known.names)) or did_you_mean(name, sorted(known.texts))


def explain_word(error: WordAfterFileError, flags: Container[str]) -> UsageError:
    """The error about a word behind a launch file, with what it was probably meant to be.

    `flags` are the options of the command.
    """
    word = error.word
    with silence():
        plan = make_plan(str(error.path), ())
        specs = [process.spec for process in plan.processes]
        arguments = sorted(plan.declared)
        if plan.error is None:
            known = known_names(plan)
            arguments = sorted(known.names | known.texts)
    nodes = {spec.ros.node_name or spec.label: spec.ros for spec in specs if spec.ros}
    file, node = error.path.name, nodes.get(word)
    if node is not None and node.package and node.executable:
        error.hint = (
            f"{file} starts {word} with the others; `{program()} run {node.package} "
            f"{node.executable}` runs it alone, `{program()} restart {word}` restarts it in a "
            "running launch"
        )
        return error
    meant = [f"--{word}"] if f"--{word}" in flags else []
    if word in (*VERBS, *CONTROL_VERBS):
        target = f" {file.partition('.launch.')[0]}" if word in _OF_LAUNCH_FILES else ""
        meant.append(f"`{program()} {word}{target}`")
    if meant and word not in arguments:
        error.hint = f"did you mean {', or '.join(meant)}?"
        return error
    near = word if word in arguments else suggest(word, [*arguments, *nodes])
    if near in arguments:
        error.hint = f"did you mean {near}:=VALUE?"
    elif near is not None:
        error.hint = f"did you mean the node '{near}' of {file}?"
    else:
        listed = ", ".join(plan.declared) or "none"
        error.hint = f"arguments of {file}: {listed}"
    return error


def of_launch_file(
    fault: LaunchFileError,
    description: LaunchDescription | None,
    context: LaunchContext | None,
    arguments: Arguments,
    environment: Mapping[str, str],
) -> list[LauncherError]:
    """The fault that ended the evaluation, unless another error covers it, and the others."""
    if description is None:
        return [fault]
    given = dict(arguments)
    missing = _as_far_as_possible(map(_missing, _missing_arguments(description, given)))
    refused = _as_far_as_possible(_bad_choices(description, given))
    programs: list[LaunchFileError] = []
    if context is not None:
        programs = _as_far_as_possible(_programs(description, context, environment))
    is_covered = _REQUIRED in fault.message if missing else False
    is_covered |= _NOT_VALID in fault.message if refused else False
    is_covered |= any(error.message == fault.message for error in programs)
    return [*([] if is_covered else [fault]), *missing, *refused, *programs]


def _as_far_as_possible(found: Iterable[LaunchFileError]) -> list[LaunchFileError]:
    """The errors up to an exception of the launch file, which is reported anyway."""
    errors: list[LaunchFileError] = []
    with contextlib.suppress(Exception):
        for error in found:
            errors.append(error)
    return errors


_REQUIRED = "missing required argument"
_NOT_VALID = "is not valid. Valid options are"


# ---- arguments


def _missing_arguments(
    description: LaunchDescription, given: Mapping[str, str]
) -> Iterator[DeclareLaunchArgument]:
    """Required arguments that neither the command line nor an include on the way gives."""
    pairs = description.get_launch_arguments_with_include_launch_description_actions()
    for argument, includes in pairs:
        if argument._conditionally_included or argument.default_value is not None:
            continue
        names = set(given)
        for include in includes or ():
            names.update(include._try_get_arguments_names_without_context())
        if argument.name not in names:
            yield argument


def _missing(argument: DeclareLaunchArgument) -> LaunchFileError:
    text = argument.description
    about = "" if text == "no description given" else f" ({text})"
    value = argument.choices[0] if argument.choices else "VALUE"
    return _at(
        argument._origin,
        argument.name,
        f"the required argument '{argument.name}' is not given{about}",
        f"give {argument.name}:={value}",
    )


def _bad_choices(
    description: LaunchDescription, given: Mapping[str, str]
) -> Iterator[LaunchFileError]:
    pairs = description.get_launch_arguments_with_include_launch_description_actions()
    for argument, includes in pairs:
        value = given.get(argument.name)
        if value is None or argument.choices is None or value in argument.choices:
            continue
        if argument._conditionally_included or includes:
            continue  # it may be skipped, or an include may give it another value
        near = near_choice(value, argument.choices)
        listed = f"choices: {', '.join(argument.choices)}"
        yield _at(
            argument._origin,
            argument.name,
            f"argument '{argument.name}' cannot be '{value}'",
            f"did you mean {argument.name}:={near}?" if near else listed,
        )


# ---- programs


def _programs(
    description: LaunchDescription, context: LaunchContext, environment: Mapping[str, str]
) -> Iterator[LaunchFileError]:
    """Packages and executables of nodes that do not exist."""
    for node in _nodes(description, context):
        names = _text(node.node_package, context), _text(node.node_executable, context)
        if names[0] is None or names[1] is None:
            continue
        try:
            find_executable(names[0], names[1], environment)
        except LaunchFileError as error:
            message = error.message.strip('"')
            word = names[0] if message.startswith("package") else names[1]
            yield _at(node._origin, word, message, error.hint)


def _nodes(entity: Any, context: LaunchContext) -> Iterator[Node]:
    """Nodes below an entity that are certain to be started."""
    if isinstance(entity, Node):
        if entity.node_package is not None and _is_wanted(entity, context):
            yield entity
        return
    if isinstance(entity, IncludeLaunchDescription) or not _is_wanted(entity, context):
        return
    for below in entity.describe_sub_entities():
        yield from _nodes(below, context)


def _is_wanted(entity: object, context: LaunchContext) -> bool:
    condition = getattr(entity, "condition", None)
    if condition is None:
        return True
    expression = getattr(condition, "predicate_expression", ())
    if not expression or not all(isinstance(part, _KNOWN_BEFOREHAND) for part in expression):
        return False
    try:
        return bool(condition.evaluate(context))
    except Exception:  # not known yet: no mistake is reported
        return False


def _text(parts: object, context: LaunchContext) -> str | None:
    """The text if that can be known without running anything."""
    subs = normalize_to_list_of_substitutions(parts)
    if not all(isinstance(sub, _KNOWN_BEFOREHAND) for sub in subs):
        return None
    try:
        return perform_substitutions(context, subs)
    except Exception:  # not known yet: no mistake is reported
        return None


# ---- places


def _at(origin: FileLine | None, word: str, message: str, hint: str | None) -> LaunchFileError:
    """An error at a place, the caret below `word` if the line has it."""
    if origin is None:
        return LaunchFileError(message, hint=hint)
    line = linecache.getline(origin.path, origin.line).rstrip("\n")
    column = line.find(word) + 1 or len(line) - len(line.lstrip()) + 1
    return LaunchFileError(
        message,
        hint=hint,
        where=str(origin),
        source_line=line or None,
        column=column if line else None,
    )
