"""`completion SHELL`: print the script that completes command lines of the launcher in a shell."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, option
from launcher.base.errors import ExitCode
from launcher.base.verb_table import VERBS

COMMAND = Command(
    "completion",
    VERBS["completion"],
    arguments=(
        option("SHELL", choices=("bash", "zsh", "fish")),
        option("[WORD ...]", default=(), name="words", count="..."),
    ),
    synopsis="bash|zsh|fish",
    about="""\
Print a script that completes verbs, options, launch files with their arguments, packages,
executables, processes of running launches, topics, nodes, services, actions, types and
transitions. In the shell's start file:

  bash  source <(launcher completion bash)               # ~/.bashrc
  zsh   source <(launcher completion zsh)                # ~/.zshrc, behind compinit
  fish  launcher completion fish | source                # ~/.config/fish/config.fish

It completes the command `launcher`; for `python -m launcher`: alias launcher='python -m launcher'.
The script calls this verb with the words of the command line.""",
)


def main(words: Sequence[str]) -> int:
    """Print the script, or the completions of the words behind the shell; the exit code."""
    parsed = COMMAND.parse(words)
    if not parsed.words:
        from launcher.cli.completion.scripts import script

        sys.stdout.write(script(parsed.shell))
        return ExitCode.OK
    from launcher.cli.completion import answers

    sys.stdout.write(answers.answer(parsed.shell, parsed.words))
    return ExitCode.OK
