"""What `--help` prints of a command."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from launcher.base.command_line import Command
from launcher.base.option import HELP, WORKSPACE, Option

WIDTH = 96
INDENT = 25  # columns in front of the explanations


def help_text(command: Command) -> str:
    usages = command.usage.split("\n")
    parts = ["\n       ".join([f"usage: {usages[0]}", *usages[1:]])]
    parts.append(command.about or sentence(command.help))
    if command.commands:
        rows = [(one.name.rpartition(" ")[2], one.help) for one in command.commands]
        parts.append(_section("verbs", rows))
        parts.append(f"{command.usage.removesuffix(' ...')} --help lists the options of a verb.")
    explained = [(one.metavar, explanation(one)) for one in command.arguments if one.help]
    if explained:
        parts.append(_section("arguments", explained))
    # In the console, `help VERB` is how help is asked for.
    options = (*command.options, WORKSPACE, HELP) if command.in_shell else command.options
    if command.commands:
        options = command.options
    if options:
        parts.append(option_section("options", options))
    parts += [option_section(title, options) for title, options in command.groups]
    return "\n\n".join([*parts, *([command.epilog] if command.epilog else [])])


def sentence(text: str) -> str:
    """A line of help, as a complete sentence."""
    return f"{text[0].upper()}{text[1:]}."


def option_section(title: str, options: Iterable[Option]) -> str:
    return _section(title, [(one.spelling, explanation(one)) for one in options])


def explanation(option: Option) -> str:
    """What an option does, with its choices and its default."""
    one_of = " | ".join(option.choices)
    text = ": ".join(filter(None, (option.help, one_of)))
    has_default = option.default and isinstance(option.default, (int, float, str))
    if "(default: " in option.help:  # as the user writes it: 100M, not the number of bytes
        return text
    return f"{text} (default: {option.default})" if has_default else text


def _section(title: str, rows: Iterable[tuple[str, str]]) -> str:
    lines = [f"{title}:"]
    for left, right in rows:
        head = f"  {left}"
        below = textwrap.wrap(right, WIDTH - INDENT)
        if len(head) <= INDENT - 2 and below:
            head = f"{head:<{INDENT}}{below.pop(0)}"
        lines += [head, *(f"{'':<{INDENT}}{line}" for line in below)]
    return "\n".join(lines)
