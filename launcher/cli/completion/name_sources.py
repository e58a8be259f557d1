"""The names that are completed: files, packages, arguments, processes, what is in the ROS graph."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence

from launcher.base.errors import LauncherError, PackageNotFoundError
from launcher.base.verb_table import module_of

SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml")
_INDEX = "share/ament_index/resource_index/packages"

Candidates = Iterable[tuple[str, str]]


def files(current: str) -> Iterator[tuple[str, str]]:
    """Files and folders whose path begins with `current`."""
    return _entries(current, lambda name: True)


def folders(current: str) -> Iterator[tuple[str, str]]:
    return _entries(current, lambda name: False)


def _entries(current: str, is_wanted: Callable[[str], bool]) -> Iterator[tuple[str, str]]:
    folder, _, begin = current.rpartition("/")
    start = f"{folder}/" if "/" in current else ""
    with contextlib.suppress(OSError), os.scandir(os.path.expanduser(start) or ".") as entries:
        for entry in sorted(entries, key=lambda entry: entry.name):
            if not entry.name.startswith(begin) or (entry.name[0] == "." and not begin):
                continue
            if entry.is_dir():
                yield f"{start}{entry.name}/", ""
            elif is_wanted(entry.name):
                yield f"{start}{entry.name}", ""


def signals(current: str) -> Candidates:
    return [(one.name, "") for one in signal.Signals]


def levels(current: str) -> Candidates:
    return [*logger_levels(current), ("ALL", "")]


def logger_levels(current: str) -> Candidates:
    from launcher.output.filters import LEVELS

    return [(name, "") for name in LEVELS]


# ---- launch files and packages


def targets(current: str) -> Iterator[tuple[str, str]]:
    """Launch files by name and by path, and, once a letter is typed, packages."""
    from launcher.language.frontends.locate import launch_names

    if "/" not in current:
        yield from ((name, "launch file") for name in launch_names(os.environ))
    yield from _entries(current, lambda name: name.endswith(SUFFIXES))
    if current and "/" not in current:
        yield from packages(current)


def packages(current: str) -> Iterator[tuple[str, str]]:
    from launcher.packages.finder import search_prefixes

    for prefix in search_prefixes(os.environ):
        with contextlib.suppress(OSError):
            yield from ((name, "package") for name in sorted(os.listdir(prefix / _INDEX)))


def executables(package: str) -> Candidates:
    """LauncherError: there is no such package."""
    from launcher.packages.finder import executables as names

    return [(name, "") for name in names(package, os.environ)]


def launch_words(before: Sequence[str], current: str) -> Iterable[tuple[str, str]]:
    """A target, the file of a package, or an argument of the launch file."""
    named = [word for word in before if ":=" not in word]
    if not named:
        return targets(current)
    if len(named) == 1 and named == list(before):
        with contextlib.suppress(PackageNotFoundError):
            return _files_of(named[0])
    given = {word.partition(":=")[0] for word in before if ":=" in word}
    return _arguments(named, given, current)


def _files_of(package: str) -> list[tuple[str, str]]:
    """Launch files of a package; PackageNotFoundError, also for the name of a launch file."""
    from launcher.language.frontends.locate import launch_names
    from launcher.packages.finder import share_directory

    if package in launch_names(os.environ) or os.path.isfile(package):
        raise PackageNotFoundError(f"'{package}' is a launch file")
    share = share_directory(package, os.environ)
    return [(p.name, "") for suffix in SUFFIXES for p in sorted(share.rglob(f"*{suffix}"))]


def _arguments(words: Sequence[str], given: set[str], current: str) -> Iterator[tuple[str, str]]:
    from launcher.language.frontends.locate import locate
    from launcher.launch.declared_arguments import SWITCH, declared_arguments, default_of

    name, has_value, value = current.partition(":=")
    for argument in declared_arguments(str(locate(words, os.environ))):
        if has_value and argument.name == name:
            known = argument.choices or (SWITCH if default_of(argument).lower() in SWITCH else ())
            values = known or [path for path, _ in files(value)]
            yield from ((f"{name}:={one}", "") for one in values)
        elif not has_value and argument.name not in given:
            yield f"{argument.name}:=", argument.description or ""


# ---- what is running


def runs(current: str) -> Candidates:
    from launcher.control.active_runs import ListedRun, all_runs

    return [(run.run_id, run.target) for run in all_runs() if isinstance(run, ListedRun)]


def processes(run: str | None) -> Candidates:
    """Those of a run, or of all runs."""
    from launcher.control.active_runs import ListedRun, all_runs

    found = [each for each in all_runs() if isinstance(each, ListedRun)]
    wanted = [each for each in found if run is None or each.run_id.startswith(run)]
    return [(name, each.short_target) for each in wanted for name in each.processes]


def topics(current: str) -> Candidates:
    return _lines("topic", "list")


def nodes(current: str) -> Candidates:
    return _lines("node", "list")


def services(current: str) -> Candidates:
    return _lines("service", "list")


def types(current: str) -> Candidates:
    return [(line, "") for line, _ in _lines("interface", "list") if "/" in line]


def actions(current: str) -> Candidates:
    return _lines("action", "list")


def types_of(verb: str, before: Sequence[str]) -> Candidates:
    """The type of the service or action that was named; all such types, if it has none yet."""
    found = _lines(verb, "type", before[0]) if before else []
    only = "--only-srvs" if verb == "service" else "--only-actions"
    return found or [(line, "") for line, _ in _lines("interface", "list", only) if "/" in line]


def lifecycle_nodes(current: str) -> Candidates:
    return _lines("lifecycle", "nodes")


def transitions(node: str) -> Candidates:
    """The labels of those that a node can make now."""
    lines = [line for line, _ in _lines("lifecycle", "list", node) if line.startswith("- ")]
    return [(line[2:].partition(" [")[0], "") for line in lines]


def parameters(node: str) -> Candidates:
    return _lines("param", "list", node)


def _lines(verb: str, *words: str) -> list[tuple[str, str]]:
    """What a verb lists, without its notes; nothing if it fails."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.suppress(LauncherError):
        importlib.import_module(module_of(verb)).main(words)
    return [(line.strip(), "") for line in output.getvalue().splitlines()]
