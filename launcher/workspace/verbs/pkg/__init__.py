"""`pkg VERB ...`: make packages, and look at those that are installed."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.errors import LauncherError
from launcher.base.verb_table import VERBS
from launcher.workspace.verbs.pkg.create import CREATE
from launcher.workspace.verbs.pkg.look import EXECUTABLES, LIST, PREFIX, XML


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.read(words)
    if parsed.problem is not None:
        if parsed.command is CREATE and parsed.node:
            _explain_nodes(parsed.problem)
        raise parsed.problem
    assert parsed.command.run is not None
    return parsed.command.run(parsed)


def _explain_nodes(problem: LauncherError) -> None:
    if problem.message.startswith("unexpected argument"):
        problem.hint = "repeat the option for each node: --node first --node second"


COMMAND = Command("pkg", VERBS["pkg"], commands=(CREATE, LIST, PREFIX, EXECUTABLES, XML))
