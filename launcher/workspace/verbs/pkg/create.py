"""`pkg create NAME`: make packages that `build` and `test` take as they are."""

from __future__ import annotations

import os
import sys

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG, option
from launcher.base.text import escape
from launcher.base.verb_table import CONTROL_VERBS, VERBS
from launcher.workspace.building.create import BUILD_TYPES


def _create(options: Parsed) -> int:
    from launcher.workspace.building.create import create

    request = create.CreateRequest(
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


CREATE = Command(
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
            choices=BUILD_TYPES,
        ),
        option(
            "--dependencies PACKAGE ...",
            "packages that it depends on",
            default=(),
            repeat="all",
        ),
        option("--package-format N", "of package.xml, for compatibility with ros2", choices=("3",)),
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
)
