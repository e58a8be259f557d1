"""`demo [name:=value ...]`: run the robot fleet that comes with the launcher, from any folder."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.command_line import Command, HelpRequested
from launcher.base.errors import UsageError
from launcher.base.option import HELP
from launcher.base.program import program
from launcher.base.verb_table import VERBS
from launcher.packages.source_packages import choose_demo

LAUNCH_FILE = "system.launch.py"

COMMAND = Command(
    "demo",
    VERBS["demo"],
    synopsis="[name:=value ...] [options of launch]",
    about=f"""\
Run the robot fleet that comes with the launcher, from any folder: a dispatcher assigns a task per
second to three robots, and a monitor counts what they have finished. Ctrl-C stops it.

It is {LAUNCH_FILE} of its package, with all options of `launch`: `demo --show-args` lists its
arguments, `demo enable_debug:=true` prints every message. A launch file or a package of yours that
is called demo is run by `launch demo`.""",
)


def main(words: Sequence[str]) -> int:
    """Launch the fleet; the exit code is that of `launch`."""
    if any(word in HELP.flags for word in words):
        raise HelpRequested(COMMAND)
    from launcher.launch.verbs import launch

    return launch.main(launch_words(words))


def launch_words(words: Sequence[str]) -> list[str]:
    """The words of `launch` for those of `demo`; UsageError."""
    if words and ".launch." in words[0]:
        hint = f"if it is in a package called demo: {program()} launch demo {words[0]}"
        raise UsageError(f"`demo` takes no launch file: '{words[0]}'", hint=hint)
    name = choose_demo()
    if name is None:
        raise UsageError(
            "this installation of the launcher has no demo",
            hint="an old pip has left it out: update pip, and install the launcher again",
        )
    return [name, LAUNCH_FILE, *words]
