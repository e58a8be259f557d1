"""`pkg create NAME`: make packages that `build` and `test` take as they are."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from launcher.build.create import create
from launcher.command_line import DEBUG, Command, Parsed, option
from launcher.commands import CONTROL_VERBS, VERBS
from launcher.errors import ExitCode, UsageError
from launcher.program import program
from launcher.text import escape

# Verbs of `ros2 pkg` that do not exist here, with an alternative.
_ABSENT = {
    "executables": "PROGRAM run PACKAGE lists the executables of a package",
    "list": "the packages of the environment: ls PREFIX/share/ament_index/resource_index/packages",
    "prefix": "the packages of pip are in PREFIX, those of a workspace in install/",
    "xml": "package.xml is in share/PACKAGE/, below PREFIX or install/PACKAGE/",
}


def main(words: Sequence[str]) -> int:
    if words and words[0] in _ABSENT:
        hint = _ABSENT[words[0]].replace("PROGRAM", program()).replace("PREFIX", sys.prefix)
        raise UsageError(f"ros2cli's verb 'pkg {words[0]}' does not exist here", hint=hint)
    parsed = COMMAND.read(words)
    if parsed.problem is not None:
        if parsed.node and parsed.problem.message.startswith("unexpected argument"):
            parsed.problem.hint = "each node has an option of its own: --node first --node second"
        raise parsed.problem
    assert parsed.command.run is not None
    return parsed.command.run(parsed)


def _create(options: Parsed) -> int:
    request = create.Request(
        name=options.name,
        nodes=options.node,
        with_interfaces=options.interfaces,
        build_type=options.build_type,
        dependencies=[one for some in options.dependencies for one in some],
        folder=options.destination_directory,
        description=options.description,
        license=options.license,
        maintainer=options.maintainer_name,
        email=options.maintainer_email,
        verbs=("help", *VERBS, *CONTROL_VERBS),
    )
    made = create.create(request, dict(os.environ))
    for warning in made.warnings:
        print(escape(f"warning: {warning}"), file=sys.stderr)
    print("\n".join(made.lines))
    return ExitCode.OK


COMMAND = Command(
    "pkg",
    VERBS["pkg"],
    commands=(
        Command(
            "pkg create",
            "make a package with examples and tests",
            arguments=(option("NAME", "name of the package"),),
            options=(
                option(
                    "--node-name, --node NODE",
                    "an example node of this name; may be given several times",
                    default=(),
                    repeat="all",
                ),
                option("--interfaces", "an example message, service and action"),
                option(
                    "--build-type TYPE",
                    "as with `ros2 pkg create`; the other options decide it",
                    choices=create.BUILD_TYPES,
                ),
                option(
                    "--dependencies PACKAGE ...",
                    "packages that it depends on",
                    default=(),
                    repeat="all",
                ),
                option("--destination-directory DIR", "folder for the package"),
                option("--description TEXT", "for package.xml"),
                option("--license LICENSE", "for package.xml, such as Apache-2.0"),
                option("--maintainer-name NAME", "for package.xml; by default git's user.name"),
                option("--maintainer-email EMAIL", "the same; by default git's user.email"),
                DEBUG,
            ),
            about="""\
Make a package that `build` and `test` take as it is: an ament_python package with nodes, a launch
file and tests, or with --interfaces an ament_cmake package of example types with a test. With both
--interfaces and --node there are two packages, NAME and NAME_interfaces, whose message and service
the nodes use. They go into src/ in the root of a workspace, else into the working directory.""",
            run=_create,
        ),
    ),
)
