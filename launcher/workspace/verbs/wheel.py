"""`wheel PACKAGE ...`: make wheels of built packages of a workspace."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping, Sequence

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode, UsageError
from launcher.base.option import DEBUG, option
from launcher.base.program import program
from launcher.base.verb_table import VERBS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.workspace.building.build_place import Place

COMMAND = Command(
    "wheel",
    VERBS["wheel"],
    arguments=(option("[PACKAGE ...]", default=()),),
    about="""\
Make wheels of built packages of the workspace, to be installed by pip where there is no compiler.
Packages of the workspace that they need are made as well; packages of the ROS wheels become
requirements. A package that cannot be packed does not stop the others. Message packages and others
that CMake installs are taken from install/, Python packages from their sources. The same sources
give the same bytes, with the same Python, wheels and compiler.

The platform is the oldest manylinux that the libraries allow: that of the compiler's system, and
manylinux_2_28 or older with `PROGRAM build --compiler zig`.""".replace("PROGRAM", program()),
    options=(
        option("-o, --output DIR", "folder for the wheels, dist/ in the workspace by default"),
        option("--all", "all packages of the workspace"),
        option("--no-deps", "only the named packages"),
        DEBUG,
    ),
    epilog="exit codes: 0 the wheels are written, 1 a package is not built or cannot be packed, "
    "2 bad command line or bad package, 130 interrupted by Ctrl-C, 143 by SIGTERM",
)


def main(words: Sequence[str]) -> int:
    options = COMMAND.parse(words)
    if bool(options.package) == options.all:
        raise UsageError(
            "--all takes no packages" if options.all else "name a package, or give --all",
            hint=f"{program()} wheel --help",
        )
    from launcher.packages import workspace
    from launcher.packages.environment import of_build
    from launcher.workspace.building import build_place, extra
    from launcher.workspace.building.colcon import build_signals
    from launcher.workspace.building.sources.source_text import shown

    found = workspace.current()
    where = build_place.find([found.root] if found else [])
    extra.require()
    env = of_build(found, os.environ) if found else dict(os.environ)
    output = os.path.abspath(options.output or os.path.join(where.root, "dist"))
    try:
        with build_signals.end_the_build():
            wheels = _make(where, options.package, output, env, alone=options.no_deps)
    except (KeyboardInterrupt, build_signals.BuildTerminated) as stop:
        return build_signals.interrupted(stop, "finished wheels are kept")
    # By their files: by name, pip would take a newer package of the same name from PyPI.
    print(f"install with: {shlex.join(['pip', 'install', *map(shown, wheels)])}")
    return ExitCode.OK


def _make(
    where: Place, names: Sequence[str], output: str, env: Mapping[str, str], *, alone: bool
) -> list[str]:
    """The paths of the wheels; each is printed when it is written."""
    from launcher.workspace.building import lock
    from launcher.workspace.building.sources.source_text import shown
    from launcher.workspace.building.wheel import maker

    chosen, packages = maker.selected(where, names, env, alone=alone)
    paths = []
    with lock.held(where):
        for wheel in maker.make(where, chosen, packages, output, env):
            for warning in wheel.warnings:
                print(f"warning: {os.path.basename(wheel.path)}: {warning}", file=sys.stderr)
            state = "" if wheel.is_new else ", unchanged"
            print(f"{shown(wheel.path)} ({wheel.size / 1000:.0f} kB{state})")
            paths.append(wheel.path)
    return paths
