"""`completion SHELL`: print the script that completes command lines of the launcher in a shell."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode
from launcher.base.option import option
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
        sys.stdout.write(script(parsed.shell))
        return ExitCode.OK
    from launcher.cli.completion.candidates import answer

    sys.stdout.write(answer(parsed.shell, parsed.words))
    return ExitCode.OK


# ---- the scripts: they hand the words to `launcher completion` and offer what it prints

# The program that is being completed, or ours where that is an alias.
_PROGRAM = """\
    local program
    program=$(command -v -- "$1") && [ -x "$program" ] && set -- "$program" || set -- {ours}
"""
_BASH = """\
# Completion of `launcher` in bash.
_launcher_completion() {{
{program}    local IFS=$'\\n'
    # Everything is escaped already, and what needs a space has one.
    COMPREPLY=($("$@" completion bash "${{COMP_LINE:0:COMP_POINT}}" "$COMP_WORDBREAKS" 2>/dev/null))
}}
complete -o nospace -F _launcher_completion launcher
"""
_ZSH = """\
#compdef launcher
# Completion of `launcher` in zsh.
_launcher_completion() {{
    local line text
    local -a full open full_texts open_texts
    set -- "${{(Q)words[1]}}"
{program}    set -- "$@" completion zsh "${{(@Q)words[2,CURRENT]}}"
    for line in "${{(@f)$("$@" 2>/dev/null)}}"; do
        [[ -n $line ]] || continue
        text=${{line/$'\\t'/  -- }}
        line=${{line%%$'\\t'*}}
        if [[ $line == *(:=|/|=) ]]; then
            open+=("$line") open_texts+=("$text")
        else
            full+=("$line") full_texts+=("$text")
        fi
    done
    (( $#full )) && compadd -l -d full_texts -- "${{full[@]}}"
    (( $#open )) && compadd -l -S '' -d open_texts -- "${{open[@]}}"
}}
compdef _launcher_completion launcher
"""
_FISH = """\
# Completion of `launcher` in fish.
function __launcher_completion
    set -l words (commandline -opc)
    set -l program (command -s -- $words[1]); or set program {ours}
    $program completion fish $words[2..-1] (commandline -ct) 2>/dev/null
end
complete -c launcher -f -a '(__launcher_completion)'
"""


def script(shell: str) -> str:
    """The script for bash, zsh or fish."""
    ours = f"{shlex.quote(os.path.abspath(sys.executable))} -m launcher"
    text = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}[shell]
    return text.format(program=_PROGRAM.format(ours=ours), ours=ours)
