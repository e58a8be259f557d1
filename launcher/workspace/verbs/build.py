"""`build [PATH ...]`: build the packages of a workspace."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, split_at_dashes
from launcher.base.option import DEBUG, option
from launcher.base.text import escape
from launcher.base.verb_table import VERBS

COMMAND = Command(
    "build",
    VERBS["build"],
    arguments=(option("[PATH ...]", default=()),),
    synopsis="[PATH ...] [options] [-- OPTIONS OF COLCON]",
    about="""\
Build the packages below src/ that have changed, with colcon, CMake and a compiler from pip: message
packages, Python packages, C and C++ without rclcpp, and packages that only install files. PATH is a
workspace, a folder in it, or a package's folder, which is built with what it depends on; without
PATH it is the working directory. Results are in build/, install/ and log/.

Packages are checked first: as long as one has a mistake, nothing is built.

Files of Python packages, launch and configuration files are linked into install/: editing them
needs no build.""",
    options=(
        option(
            "--compiler NAME",
            "auto (that of CC and CXX, else the system's, else zig), system, zig, or a C compiler",
            default="auto",
        ),
        option("--copy", "install copies of the files instead of links"),
        option("--cpp", "generate messages for C++ as well, which takes twice as long"),
        option("--all", "build unchanged packages as well"),
        option("--keep-going", "build what has no mistakes, although other packages have"),
        DEBUG,
    ),
    epilog="exit codes: 0 everything is built, 1 a package failed or building is not possible, "
    "2 bad command line, or a package with a mistake, 130 interrupted by Ctrl-C, 143 by SIGTERM",
)


def main(words: Sequence[str]) -> int:
    words, rest = split_at_dashes(words)
    options = COMMAND.parse(words)
    from launcher.workspace.building import build_place, extra
    from launcher.workspace.building.colcon import colcon_arguments, colcon_options

    colcon_arguments.check(rest)
    where = build_place.find(options.path)
    build_place.require_writable(where)
    extra.require()
    colcon_options.check(rest)
    from launcher.packages.environment import of_build, underlays
    from launcher.packages.workspace import Workspace
    from launcher.workspace.building import build_report, builder
    from launcher.workspace.building.colcon import build_signals

    workspace = Workspace(where.root, where.install)
    environ = of_build(workspace, os.environ)
    for path in underlays(workspace):
        if not os.path.isdir(path):
            text = f"warning: it was built on {path}, which does not exist any more"
            print(escape(text), file=sys.stderr)
    asked = builder.BuildOptions(
        compiler=options.compiler,
        links=not options.copy,
        cpp=options.cpp,
        everything=options.all,
        keep_going=options.keep_going,
        words=tuple(rest),
    )
    try:
        with build_signals.end_the_build():
            return build_report.show(builder.build(where, asked, environ))
    except (KeyboardInterrupt, build_signals.BuildTerminated) as stop:
        return build_signals.interrupted(stop, "the next build continues")
    except OSError as error:
        full = build_place.full_folders(where)
        if error.errno != errno.ENOSPC or not full:
            raise
        raise build_report.full_disk(full) from None
