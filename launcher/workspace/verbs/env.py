"""`env`: print the environment of a workspace, for shells and editors."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, JSON, option
from launcher.base.program import program
from launcher.base.verb_table import VERBS
from launcher.packages.distribution import ROS_VARIABLES
from launcher.packages.environment import LIBRARIES, merged, read
from launcher.packages.hooks import Hooks
from launcher.packages.workspace import Workspace, current
from launcher.posix.json_output import print_document

_WHEELS = "AMENT_PREFIX_PATH"


def _sh(name: str, value: str) -> str:
    return f"export {name}={shlex.quote(value)}"


def _fish(name: str, value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace("'", "\\'")
    return f"set -gx {name} '{escaped}'"


_SHELLS: dict[str, Callable[[str, str], str]] = {"sh": _sh, "fish": _fish}

COMMAND = Command(
    "env",
    VERBS["env"],
    about="""\
Print the variables that make the packages of the workspace, and those of the wheels, visible to
programs that the launcher does not start:

  sh, bash, zsh  eval "$(launcher env)"
  fish           launcher env --shell fish | source""",
    options=(
        JSON,
        option(
            "--shell SHELL",
            "the language of the output; bash and zsh understand that of sh",
            choices=(*_SHELLS,),
            default="sh",
        ),
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    """Print the variables; notes go to standard error."""
    options = COMMAND.parse(words)
    workspace = current()
    hooks = Hooks() if workspace is None else read(workspace)
    values = variables(workspace, hooks, os.environ)
    if options.json:
        print_document({"env": values})
    else:
        in_shell = _SHELLS[options.shell]
        lines = (in_shell(name, value) for name, value in values.items())
        sys.stdout.buffer.write(b"".join(os.fsencode(f"{line}\n") for line in lines))
    notes = [f"{script} was not run: it has no .dsv file" for script in hooks.scripts]
    if workspace is None:
        notes.append(f"{_why_none()}: only the packages of the wheels are visible")
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return ExitCode.OK


def _why_none() -> str:
    from launcher.workspace.building.build_place import unbuilt

    place = unbuilt()
    if place is None:
        return "there is no workspace here"
    return f"the workspace {place.root} is not built (`{program()} build`)"


def variables(
    workspace: Workspace | None, hooks: Hooks, environ: Mapping[str, str]
) -> dict[str, str]:
    """The variables that are set, sorted by their name."""
    result = dict(environ) if workspace is None else merged(hooks, environ, workspace.install)
    if LIBRARIES in hooks.front:
        result[LIBRARIES] = _in_order(result[LIBRARIES], hooks.front[LIBRARIES])
    names = {_WHEELS, *ROS_VARIABLES, *hooks.front, *hooks.back, *hooks.values}
    return {name: result[name] for name in sorted(names) if name in result}


def _in_order(value: str, first: Sequence[str]) -> str:
    """The libraries of the workspace, and then the others, in the same order at each call.

    The wheels have Python shuffle the entries when it starts.
    """
    others = (path for path in value.split(os.pathsep) if path not in first)
    ours = f"{sys.prefix}/"
    rest = sorted(others, key=lambda path: (not path.startswith(ours), path))
    return os.pathsep.join([*first, *rest])
