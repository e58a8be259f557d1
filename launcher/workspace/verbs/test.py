"""`test [PACKAGE ...]`: run the tests of the packages of a workspace."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed, split_at_dashes
from launcher.base.errors import ExitCode
from launcher.base.github import GITHUB_EXCLUSIVE, GITHUB_OPTIONS, add_summary, wants_github
from launcher.base.option import DEBUG, count, option, positive_seconds
from launcher.base.program import program
from launcher.base.text import escape
from launcher.base.verb_table import VERBS
from launcher.output.logs.run_directory import provide_log_root
from launcher.packages.workspace import Workspace, is_install

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.workspace.building.build_place import Place
    from launcher.workspace.building.sources import Package
    from launcher.workspace.testing.package_report import Report


def _at_least_one(text: str) -> int:
    return count(text, least=1)


COMMAND = Command(
    "test",
    VERBS["test"],
    arguments=(option("[PACKAGE ...]", "all packages by default", default=()),),
    synopsis="[PACKAGE ...] [options] [-- OPTIONS OF PYTEST]",
    about="""\
Run the tests of the packages of the workspace: each package in a separate ROS domain, several at a
time. It runs pytest, or ctest where the package was built with tests. A single package has the
terminal, so that `-- --pdb` works. To test a launch file against expectations: smoke.""",
    options=(
        option("--timeout SECONDS", "end the tests of a package after this time", positive_seconds),
        option(
            "--parallel-workers N",
            "packages at a time; by default one per processor",
            _at_least_one,
        ),
        option("-v, --verbose", "print the output of packages that passed as well"),
        *GITHUB_OPTIONS,
        DEBUG,
    ),
    exclusive=(GITHUB_EXCLUSIVE,),
    epilog="exit codes: 0 a test ran and all passed, 1 a test or package failed or no test ran, "
    "2 bad command line or bad package, 130 interrupted by Ctrl-C, 143 by SIGTERM",
)


def main(words: Sequence[str]) -> int:
    words, rest = split_at_dashes(words)
    options = _options(words)
    from launcher.workspace.building import build_place, extra, lock

    where = build_place.find([])
    extra.require()
    build_place.require_writable(where)
    from launcher.workspace.testing import (
        job_runner,
        package_jobs,
        package_report,
    )

    provide_log_root(os.environ)
    env = _environment(where)
    chosen = package_jobs.select(where, options.package, env)
    built, missing = _built(chosen, where)
    todo = package_jobs.jobs(built, where, rest)
    is_single = len(chosen) == 1
    shown = package_report.Report(len(todo), in_foreground=is_single, verbose=options.verbose)
    with lock.held(where):
        running = job_runner.JobRunner(
            todo,
            env,
            shown,
            workers=options.parallel_workers or len(os.sched_getaffinity(0)),
            timeout_s=options.timeout,
            in_foreground=is_single,
        )
        outcomes = running.run()
    code = shown.summarize(outcomes, missing)
    if wants_github(github=options.github, no_github=options.no_github):
        _report_to_github(shown)
    if running.signum is None:
        return code
    is_ctrl_c = running.signum == signal.SIGINT
    return ExitCode.INTERRUPTED if is_ctrl_c else ExitCode.TERMINATED


def _report_to_github(shown: Report) -> None:
    from launcher.workspace.testing import github

    for command in github.commands(shown.judged):
        print(command)
    if problem := add_summary(os.environ, github.summary(shown.judged, shown.total())):
        _warn(problem)


def _options(words: Sequence[str]) -> Parsed:
    """The command line in front of `--`; LauncherError."""
    options = COMMAND.read(words)
    problem = options.problem
    if problem is None:
        return options
    is_unknown = problem.message.startswith("unknown option")
    if is_unknown and not (problem.hint or "").startswith("did you mean"):
        given = problem.message.split("'")[1]
        problem.hint = f"options of pytest go behind --: {program()} test [PACKAGE ...] -- {given}"
    raise problem


def _environment(where: Place) -> dict[str, str]:
    """That of the workspace, if it is built."""
    from launcher.packages.environment import environment

    if not is_install(where.install):
        return dict(os.environ)
    return environment(Workspace(where.root, where.install), os.environ)


def _built(chosen: Sequence[Package], where: Place) -> tuple[list[Package], list[str]]:
    """The packages that are built, and the names of the others; warns of what is stale."""
    from launcher.doctor.stale_workspace import inspect
    from launcher.packages.environment import packages

    installed, changed = {}, {}
    if is_install(where.install):
        installed = packages(where.install)
        changed = inspect(Workspace(where.root, where.install), os.environ).changed
    built = [package for package in chosen if package.name in installed]
    missing = [package.name for package in chosen if package not in built]
    if missing:
        them = "it" if len(missing) == 1 else "them"
        _warn(f"not built: {', '.join(missing)}; to build {them}: {program()} build")
    for package in built:
        if package.name in changed:
            reason = changed[package.name]
            _warn(f"the build of {package.name} is stale ({reason}): {program()} build")
    return built, missing


def _warn(text: str) -> None:
    print(escape(f"warning: {text}"), file=sys.stderr)
