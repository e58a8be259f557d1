"""Which packages are tested, and what is run for each: pytest, or ctest if built with tests."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from launcher.base.errors import LauncherError, SeveralErrors, UsageError
from launcher.base.program import program
from launcher.base.text import did_you_mean
from launcher.language.frontends.locate import launch_names
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.workspace.building import sources
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.sources import Package

# They would connect the nodes to other machines.
_NOT_INHERITED = ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS")
_BUILD_TESTING = re.compile(r"BUILD_TESTING:\w+=(ON|TRUE|YES|Y|1)$", re.IGNORECASE)
# The files that pytest reads, in its order, and what in them is for it.
_CONFIGURATIONS = {
    "pytest.toml": "",
    ".pytest.toml": "",
    "pytest.ini": "",
    ".pytest.ini": "",
    "pyproject.toml": r"^\s*\[\s*tool\s*\.\s*pytest\b",
    "tox.ini": r"^\[pytest\]",
    "setup.cfg": r"^\[tool:pytest\]",
}
NO_TESTS_COLLECTED = 5  # pytest's exit code


@dataclass(frozen=True)
class Job:
    """The tests of a package: `command` in `folder`.

    `results` are the files that colcon's `test-result` reads, `log` has the output.
    """

    package: str
    source: str
    folder: str
    command: tuple[str, ...]
    results: str
    log: str
    is_ctest: bool = False


def jobs(packages: Iterable[Package], place: Place, words: Sequence[str]) -> list[Job]:
    """One job for each package; `words` are more options of pytest. LauncherError."""
    return [_job(package, place, words) for package in packages]


def _job(package: Package, place: Place, words: Sequence[str]) -> Job:
    build = os.path.join(place.build, package.name)
    log = os.path.join(build, "test.log")
    if _has_ctest(build):
        results = os.path.join(build, "test_results", package.name)
        command = _ctest(build)
        return Job(package.name, package.folder, build, command, results, log, is_ctest=True)
    results = os.path.join(build, "pytest.xml")
    command = (
        *(sys.executable, "-m", "pytest", "--tb=short"),
        f"--rootdir={package.folder}",
        *_configuration(package.folder, place.root),
        f"--junit-xml={results}",
        f"--junit-prefix={package.name}",
        *("-o", "junit_family=xunit1"),  # it has the lines of tests
        *("-o", f"cache_dir={os.path.join(build, '.pytest_cache')}"),
        *words,
    )
    return Job(package.name, package.folder, package.folder, command, results, log)


def _configuration(package: str, root: str) -> tuple[str, ...]:
    """Options for the configuration in the package, else in a folder above it in the workspace.

    Without them pytest would also take that of a folder around the workspace, such as a checkout.
    """
    folders = [package, *map(str, Path(package).parents)]
    within = folders[: folders.index(root) + 1] if root in folders else folders[:1]
    for folder in within:
        for name, section in _CONFIGURATIONS.items():
            path = os.path.join(folder, name)
            if _has_section(path, section):
                return ("-c", path)
    return ("-c", os.devnull, f"--confcutdir={package}")  # conftest.py is not looked for above


def _has_section(path: str, section: str) -> bool:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return re.search(section, file.read(), re.MULTILINE) is not None
    except OSError:
        return False


def _has_ctest(build: str) -> bool:
    """Whether CMake was run with BUILD_TESTING, which `build` does only on request."""
    try:
        with open(
            os.path.join(build, "CMakeCache.txt"), encoding="utf-8", errors="replace"
        ) as file:
            is_on = any(_BUILD_TESTING.match(line) for line in file)
    except OSError:
        return False
    return is_on and os.path.isfile(os.path.join(build, "CTestTestfile.cmake"))


def _ctest(build: str) -> tuple[str, ...]:
    """As `colcon test` starts it; the summary goes to a file that `colcon test-result` ignores."""
    beside = os.path.join(os.path.dirname(sys.executable), "ctest")
    program = beside if os.path.isfile(beside) else shutil.which("ctest")
    if program is None:
        raise LauncherError("ctest is missing", hint="pip install 'cmake<4'")
    return (
        *(program, "-D", "ExperimentalTest", "--no-compress-output", "--force-new-ctest-process"),
        *("--output-on-failure", "--output-junit", ctest_summary(build)),
    )


def ctest_summary(build: str) -> str:
    return os.path.join(build, "ctest.junit")


def environment(environ: Mapping[str, str], domain_id: int, run_id: str) -> dict[str, str]:
    """`environ` for the tests of one package."""
    return {
        **{name: value for name, value in environ.items() if name not in _NOT_INHERITED},
        RUN_ID_VARIABLE: run_id,
        "ROS_DOMAIN_ID": str(domain_id),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        # The output of a process that has to be killed is not lost, and shows where it was.
        "PYTHONUNBUFFERED": "1",
        "PYTHONFAULTHANDLER": "1",
    }


def remove_results(job: Job) -> None:
    """Remove those of the last run, which would be taken for those of this one; OSError."""
    os.makedirs(os.path.dirname(job.log), exist_ok=True)
    stale = [job.log, job.results, *([ctest_summary(job.folder)] if job.is_ctest else [])]
    for path in stale:
        if os.path.isdir(path):
            shutil.rmtree(path)
        else:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(path)


def select(place: Place, names: Sequence[str], env: Mapping[str, str]) -> list[Package]:
    """The packages of these names, by default those that the place names, or all.

    UsageError for unknown names, and for packages that cannot be read.
    """
    found = sources.find([place.base], env)
    known = {package.name: package for package in found.packages}
    unknown = [name for name in names if name not in known]
    launched = launch_names(env) if unknown else []
    errors: list[LauncherError] = [
        UsageError(
            f"no package '{name}' in {place.base}",
            hint=f"to test a launch file: {program()} smoke {name}"
            if name in launched
            else did_you_mean(name, known) or f"packages: {', '.join(known) or 'none'}",
        )
        for name in unknown
    ]
    if errors or (found.errors and not names):
        raise SeveralErrors([*errors, *found.errors])
    if names:
        return [known[name] for name in dict.fromkeys(names)]
    return [one for one in found.packages if not place.named or one.folder in place.named]
