"""Prints the tree of a launch file; the page in the browser and `smoke` run this.

`python -m launcher.launch.outline WORDS`, with the words of a launch, prints one JSON
array, and nothing if the launch file cannot be planned.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from launcher.base import strict_json
from launcher.base.errors import ExitCode, LauncherError
from launcher.launch.plan.plan import Plan
from launcher.launch.plan.plan_tree import plan_tree
from launcher.launch.plan.shell_command import ParameterFileWriter
from launcher.launch.target import LaunchRequest
from launcher.launch.verbs import launch
from launcher.launch.verbs import plan as planning

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.launch.plan.tree import Branch


class _NoFiles(ParameterFileWriter):
    """Nobody pastes a command of this tree."""

    def keep(self, label: str, content: Mapping[str, Any]) -> tuple[str | None, str]:
        return None, ""


def outline(plan: Plan) -> list[dict[str, Any]]:
    """Entries with `kind`, `text`, `detail`, `place`, `name` (of a process) and `children`."""
    root = plan_tree(plan, _NoFiles())
    return [_entry(branch, plan) for branch in root.children]


def _entry(branch: Branch, plan: Plan) -> dict[str, Any]:
    process, kind = branch.process, branch.style
    is_component = kind == "process" and process is None
    return {
        "kind": "component" if is_component else kind,
        "text": branch.head,
        "detail": ", ".join(part for part in branch.aside.split(", ") if part != branch.place),
        "place": branch.place or None,
        "name": None if process is None else plan.processes[process].spec.name,
        "children": [_entry(child, plan) for child in branch.children],
    }


def main(words: Sequence[str]) -> int:
    try:
        plan = planning.evaluate(LaunchRequest.of(launch.COMMAND.parse(words)))
    except LauncherError as error:
        return error.exit_code
    if plan.error is not None:
        return ExitCode.USAGE
    print(strict_json.packed(outline(plan)))
    return ExitCode.OK


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
