"""A build: what has changed is handed to colcon."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from launcher.packages.distribution import ROS_VARIABLES
from launcher.workspace.building import lock, preflight, records, sources
from launcher.workspace.building.build_place import Place, full_folders
from launcher.workspace.building.build_progress import Progress
from launcher.workspace.building.colcon import Colcon, Event, colcon_arguments
from launcher.workspace.building.sources import Package
from launcher.workspace.building.toolchain import build_variables
from launcher.workspace.building.toolchain import versions as tools
from launcher.workspace.building.toolchain.compiler import Compiler, choose, zig_library_is_cached


@dataclass(frozen=True)
class BuildOptions:
    """`words` are colcon's, from behind `--`; `compiler` as for `compiler.choose`."""

    compiler: str = "auto"
    links: bool = True
    cpp: bool = False
    everything: bool = False
    keep_going: bool = False
    words: tuple[str, ...] = ()


@dataclass
class BuildFailure:
    """A package that was not built, with the step and what its tools wrote to stderr."""

    package: Package
    step: str
    stderr: str
    log: str


@dataclass
class BuildOutcome:
    """What became of the packages, by name; `code` is colcon's exit code."""

    place: Place
    built: list[str] = field(default_factory=list)
    unchanged: list[str] = field(default_factory=list)
    failed: list[BuildFailure] = field(default_factory=list)
    not_tried: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    code: int = 0
    errors: str = ""


def build(place: Place, options: BuildOptions, environ: Mapping[str, str]) -> BuildOutcome:
    """Build what has changed. LauncherError if nothing can be tried."""
    found = preflight.approved(place, environ, options.words, keep_going=options.keep_going)
    progress = Progress(len(found.packages))
    with lock.held(place, progress.say) as held:
        return _Build(place, options, environ, found, progress).run(held)


class _Build:
    def __init__(
        self,
        place: Place,
        options: BuildOptions,
        environ: Mapping[str, str],
        found: preflight.Approved,
        progress: Progress,
    ) -> None:
        self._place = place
        self._options = options
        self._environ = environ
        self._packages = found.packages
        self._selected = found.selected
        self._progress = progress
        self._outcome = BuildOutcome(place, refused=[*found.refused])
        self._now: dict[str, dict[str, Any]] = {}
        self._steps: dict[str, str] = {}
        self._stderr: dict[str, list[str]] = {}

    def run(self, held: int) -> BuildOutcome:
        compiler = self._compiler()
        self._make_records(compiler)
        changed = self._changed()
        self._outcome.unchanged = [one.name for one in self._packages if one.name not in {*changed}]
        if changed:
            kept = {*changed} if self._selected is None else self._selected
            self._prepare([name for name in changed if name in kept])
            self._progress.total = len(changed)
            self._run_colcon(changed, compiler, held)
            if again := self._without_failed():
                # colcon leaves out what needs a failed package in any way.
                self._keep_logs()
                self._run_colcon(again, compiler, held)
        return self._outcome

    # ---- what to build

    def _compiler(self) -> Compiler | None:
        if not any(package.is_compiled for package in self._packages):
            return None
        folder = os.path.join(self._place.build, ".launcher", "zig")
        env = build_variables.prepared(self._environ, self._place)
        return choose(self._options.compiler, env, folder)

    def _make_records(self, compiler: Compiler | None) -> None:
        prefixes = build_variables.prefixes(self._environ, self._place)
        setting = records.BuildSetting(
            place=self._place,
            links=self._options.links,
            tools=tools.fingerprint(),
            compiler=repr(compiler.identity) if compiler else "",
            options=(
                *(["--cpp"] if self._options.cpp else ()),
                *colcon_arguments.that_count(self._options.words),
            ),
            prefixes=tuple(prefixes),
            interfaces=tools.interfaces(prefixes),
            variables={name: self._environ.get(name, "") for name in ROS_VARIABLES},
        )
        needed = sources.dependencies_within(self._packages, "build", "run")
        for package in self._packages:
            # What a Python package imports does not change what is built of it.
            digests = {
                name: "" if package.is_python else self._now[name]["digest"]
                for name in sorted(needed[package.name])
            }
            last = records.read(self._place, package.name)
            self._now[package.name] = records.make(package, setting, digests, last)

    def _changed(self) -> list[str]:
        if self._options.everything or colcon_arguments.select(self._options.words):
            return [package.name for package in self._packages]
        return [
            package.name
            for package in self._packages
            if records.changes(
                records.read(self._place, package.name), self._now[package.name], self._place
            )
        ]

    def _prepare(self, changed: Sequence[str]) -> None:
        """Remove what would be wrong to keep."""
        if any(one.has_interfaces for one in self._packages if one.name in changed):
            build_variables.require_python_headers()
        for name in changed:
            last, now = records.read(self._place, name), self._now[name]
            if records.must_start_afresh(last, now) or _was_moved(self._place, now):
                _remove_built(self._place, name)
            records.store(self._place, now)

    # ---- colcon

    def _without_failed(self) -> list[str]:
        """The packages that were not tried, and need those that failed only to run or to test."""
        failed = [one.package.name for one in self._outcome.failed]
        if not failed or self._selected is not None or self._outcome.code < 0:
            return []
        needing = sources.with_dependents(self._packages, failed, "build")
        return [name for name in self._outcome.not_tried if name not in needing]

    def _keep_logs(self) -> None:
        """Name the folder of this run, not `latest_build`, which will be the next one."""
        for failure in self._outcome.failed:
            latest, name = os.path.split(failure.log)
            failure.log = os.path.join(os.path.realpath(latest), name)

    def _run_colcon(self, changed: Sequence[str], compiler: Compiler | None, held: int) -> None:
        place, words = self._place, self._options.words
        env = build_variables.prepared(self._environ, place, compiler)
        shows = colcon_arguments.show(words)
        self._progress.quiet = shows
        known = {*changed, *self._outcome.built, *self._outcome.unchanged}
        others = [one.name for one in self._packages if one.name not in known]
        if compiler is not None and compiler.is_zig and not zig_library_is_cached(compiler.cache):
            self._progress.note = "the first use of zig compiles its C++ library, 1 to 2 min"
        command = colcon_arguments.build(
            place,
            select=() if colcon_arguments.select(words) else changed,
            cmake_args=build_variables.cmake_args(compiler, cpp=self._options.cpp),
            links=self._options.links,
            words=colcon_arguments.ignoring(words, [*self._outcome.refused, *others]),
        )
        with (
            job_server(env) as shared,
            tempfile.TemporaryFile() as file,
            Colcon(place, command, shared, lock=held, errors=None if shows else file) as colcon,
        ):
            for event in colcon.events():
                if event is None:
                    self._progress.refresh()
                else:
                    self._take(event)
            self._outcome.code = colcon.wait() or self._outcome.code
            self._outcome.errors += colcon.errors()
        self._progress.clear()
        tried = {*self._outcome.built, *(one.package.name for one in self._outcome.failed)}
        if not colcon_arguments.select(words):
            names = self._outcome.not_tried or changed
            self._outcome.not_tried = [name for name in names if name not in tried]

    def _take(self, event: Event) -> None:
        kind, name, text = event["kind"], event["package"], event.get("text", "")
        if kind == "JobStarted":
            self._progress.start(name)
        elif kind == "JobProgress":
            self._steps[name] = text
            self._progress.step(name, text)
        elif kind == "StdoutLine":
            self._progress.line(name, text)
        elif kind == "StderrLine":
            self._stderr.setdefault(name, []).append(text)
        elif kind == "JobEnded":
            self._end(name, event["code"])

    def _end(self, name: str, code: int) -> None:
        if code == 0:
            if name in self._now:
                records.complete(self._place, self._now[name])
            self._outcome.built.append(name)
            self._progress.end(name)
            return
        self._progress.end(name, "failed")
        stderr = "\n".join(self._stderr.get(name, []))
        if "ninja: error: build.ninja:" in stderr:
            # ninja cannot read it, so it would not run CMake again to correct it.
            with contextlib.suppress(FileNotFoundError):
                os.remove(os.path.join(self._place.build, name, "build.ninja"))
        if full_folders(self._place):
            _remove_built(self._place, name)  # its files may be cut off
        # Options of colcon may have selected one that is not among ours.
        unknown = Package(name, self._place.base, "")
        self._outcome.failed.append(
            BuildFailure(
                package=next((one for one in self._packages if one.name == name), unknown),
                step=self._steps.get(name, ""),
                stderr=stderr,
                log=os.path.join(self._place.log, "latest_build", name),
            )
        )


def _was_moved(place: Place, record: Mapping[str, Any]) -> bool:
    """Whether the cache of CMake names other folders: the workspace was moved, or copied."""
    folder = os.path.join(place.build, record["package"])
    try:
        with open(os.path.join(folder, "CMakeCache.txt"), encoding="utf-8") as file:
            lines = file.read().splitlines()
    except OSError:
        return False
    home = f"CMAKE_HOME_DIRECTORY:INTERNAL={record['place']['source']}"
    return home not in lines or f"CMAKE_CACHEFILE_DIR:INTERNAL={folder}" not in lines


def _remove_built(place: Place, name: str) -> None:
    shutil.rmtree(os.path.join(place.build, name), ignore_errors=True)
    if not place.is_merged:
        shutil.rmtree(os.path.join(place.install, name), ignore_errors=True)


@contextlib.contextmanager
def job_server(environ: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """The environment with a job server; unchanged if MAKEFLAGS is set or cannot name its pipe.

    colcon builds as many packages at once as there are processors, and each ninja starts as many
    compilers. With a job server, as that of make, each ninja runs one, and all of them together as
    many more as there are processors.
    """
    if environ.get("MAKEFLAGS") or " " in tempfile.gettempdir():
        yield dict(environ)
        return
    count = len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory(prefix="launcher-") as folder:
        path = os.path.join(folder, "jobs")
        os.mkfifo(path, 0o600)
        tokens = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        try:
            os.write(tokens, b"+" * (count - 1))
            yield {**environ, "MAKEFLAGS": f"-j{count} --jobserver-auth=fifo:{path}"}
        finally:
            os.close(tokens)
