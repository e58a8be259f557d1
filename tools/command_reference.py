"""Write docs/reference/command-line.md: all verbs with options, from the tables that parse them.

`python -m tools.command_reference`; a test compares the page with the tables.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from launcher.base.command_help import explanation, sentence
from launcher.base.command_line import Command
from launcher.base.option import DEBUG, HELP, WORKSPACE, Option
from launcher.base.verb_table import VERBS, module_of
from launcher.control import verb as control
from launcher.control import verbs

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "command-line.md"
HEAD = """\
# Command line

Every verb with its options, as `--help` prints them. This page is generated:
`python -m tools.command_reference`.

Options may stand anywhere; after `--` every word is an argument. A value follows in the next word
or after `=`. The ROS verbs also accept what ros2 accepts: the beginning of an option (`--on` for
`--once`), short options together (`-tv`), and a negative number as an argument.

An option that several verbs take is explained with the first of them, and only named with the
others. Every verb takes the following, `completion` without `--debug`:

"""
OF_ALL = (WORKSPACE, DEBUG, HELP)
Row = tuple[str, str]  # how an option is spelled, and what it does


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
    places: dict[object, str] = {row(one): "" for one in OF_ALL}
    head = HEAD + "".join(map(item, OF_ALL))
    return "\n".join([head, *("\n".join(section(command, places)) for command in commands())])


def section(command: Command, places: dict[object, str]) -> Iterator[str]:
    """One command; options that have a place further up are only named, with a link to it."""
    yield f"## {command.name}\n"
    if command.commands:
        yield f"{sentence(command.help)}\n"
        return
    yield f"`{command.usage.partition('launcher ')[2]}`\n"
    yield f"{sentence(command.help)}\n"
    anchor = f"#{command.name.replace(' ', '-')}"
    named: list[tuple[str, str]] = []  # (what is explained at the place, the place)
    for title, options in [("", command.options), *command.groups]:
        group = (title, tuple(map(row, options)))
        if title and group in places:
            named.append((title, places[group]))
            continue
        places[group] = anchor
        known = [(f"`{one.flags[-1]}`", places.get(row(one))) for one in options]
        named += [(flag, place) for flag, place in known if place]
        new = [one for one in options if row(one) not in places]
        if new:
            if title:
                yield f"{sentence(title)[:-1]}:\n"
            yield "".join(map(item, new))
        places.update((row(one), anchor) for one in new)
    also = [
        f"[{', '.join(text for text, _ in texts)}]({place})"
        for place, texts in groupby(named, lambda one: one[1])
    ]
    if also:
        yield f"Also {', '.join(also)}.\n"


def row(option: Option) -> Row:
    return option.spelling, explanation(option)


def item(option: Option) -> str:
    return f"- `{option.spelling}`: {explanation(option)}\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
