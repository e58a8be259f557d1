"""Write docs/reference/command-line.md: all verbs with options, from the tables that parse them.

`python -m tools.command_reference`; a test compares the page with the tables.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path

from launcher.base.command_help import explanation, sentence
from launcher.base.command_line import Command
from launcher.base.option import Option
from launcher.base.verb_table import VERBS, module_of
from launcher.control import verb as control
from launcher.control import verbs

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "command-line.md"
PIPE = "\\|"
HEAD = """\
# Command line

Every verb with its options, as `--help` prints them. This page is generated:
`python -m tools.command_reference`.

Options may stand anywhere; after `--` every word is an argument. A value follows in the next word
or after `=`. Every verb also takes `--workspace DIR`, in front of it or behind it: the colcon
[workspace](launch-files.md#workspaces), instead of that around the working directory. The ROS verbs
also accept what ros2 accepts: the beginning of an option (`--on` for `--once`), short options
together (`-tv`), and a negative number as an argument.
"""


def commands() -> Iterator[Command]:
    """All commands of a shell, those of a verb's own verbs included."""
    for name in VERBS:
        command: Command = importlib.import_module(module_of(name)).COMMAND
        yield command
        yield from command.commands
    yield from (control.command_of(verb) for verb in verbs.VERBS if verb.shell)
    yield control.RUNS


def page() -> str:
    """The whole page."""
    seen: dict[str, str] = {}
    return "\n".join([HEAD, *("\n".join(section(command, seen)) for command in commands())])


def section(command: Command, seen: dict[str, str]) -> Iterator[str]:
    """One command; a group of options that stands further up is only referred to."""
    yield f"## {command.name}\n"
    if command.commands:
        yield f"{sentence(command.help)}\n"
        return
    yield f"`{command.usage.partition('launcher ')[2]}`\n"
    yield f"{sentence(command.help)}\n"
    groups = [("", command.options), *command.groups]
    for title, options in groups:
        if not options:
            continue
        if title in seen:
            yield f"Also the {seen[title]}.\n"
            continue
        if title:
            seen[title] = f"{title}, see [{command.name}](#{command.name.replace(' ', '-')})"
            yield f"{sentence(title)[:-1]}:\n"
        yield from table(options)


def table(options: tuple[Option, ...]) -> Iterator[str]:
    """The options as a table."""
    yield "| option | meaning |"
    yield "|---|---|"
    for option in options:
        text = explanation(option).replace("|", PIPE)
        yield f"| `{option.spelling.replace('|', PIPE)}` | {text} |"
    yield ""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
