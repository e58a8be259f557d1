"""`pkg list|prefix|executables|xml`: the packages that are installed, and what they have."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from launcher.base import text_file
from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, PackageNotFoundError
from launcher.base.option import DEBUG, option
from launcher.base.ros_errors import VerbError
from launcher.packages import finder, reading_once
from launcher.packages.workspace import current

PACKAGE = option("PACKAGE")


def _list(options: Parsed) -> int:
    _enter_workspace()
    for name in sorted(finder.package_names(os.environ)):
        print(name)
    return ExitCode.OK


def _prefix(options: Parsed) -> int:
    _enter_workspace()
    with _found("Package not found"):
        where = finder.share_directory if options.share else finder.package_prefix
        print(where(options.package, os.environ))
    return ExitCode.OK


@reading_once()
def _executables(options: Parsed) -> int:
    _enter_workspace()
    if options.package is None:
        for name in sorted(finder.package_names(os.environ)):
            with contextlib.suppress(PackageNotFoundError):  # its sources have no setup.py yet
                _print_executables(name, options)
        return ExitCode.OK
    with _found(f"Package '{options.package}' not found"):
        _print_executables(options.package, options)
    return ExitCode.OK


def _print_executables(package: str, options: Parsed) -> None:
    paths = finder.executable_paths(package, os.environ)
    for name, path in sorted(paths.items()):
        print(path if options.full_path else f"{package} {name}")


def _xml(options: Parsed) -> int:
    _enter_workspace()
    with _found("Package not found"):
        path = Path(finder.share_directory(options.package, os.environ), "package.xml")
    from xml.etree import ElementTree  # takes 2 ms

    try:
        text = text_file.read(path)
        root = ElementTree.fromstring(text)
    except FileNotFoundError:
        raise VerbError(f"Package '{options.package}' has no package.xml: {path}") from None
    except OSError as error:
        raise VerbError(f"cannot read {path}: {error.strerror}") from None
    except (UnicodeDecodeError, ElementTree.ParseError) as error:
        raise VerbError(f"{path}: {error}") from None
    if options.tag is None:
        print(text.rstrip("\n"))
        return ExitCode.OK
    found = root.findall(options.tag) if options.tag.isidentifier() else []
    if not found:
        tags = ", ".join(dict.fromkeys(element.tag for element in root))
        raise VerbError(f"XML tag '{options.tag}' not found", hint=f"tags: {tags}")
    for element in found:
        print(element.text or "")
    return ExitCode.OK


@contextlib.contextmanager
def _found(message: str) -> Iterator[None]:
    """A package that is not found is an error with the text of ros2cli."""
    try:
        yield
    except PackageNotFoundError as error:
        raise VerbError(message, hint=error.hint) from None


def _enter_workspace() -> None:
    workspace = current()
    if workspace is not None:
        from launcher.packages.activation import activate

        activate(workspace)


LIST = Command("pkg list", "list packages", options=(DEBUG,), run=_list)
PREFIX = Command(
    "pkg prefix",
    "print where a package is installed",
    arguments=(PACKAGE,),
    options=(option("--share", "the folder of its files"), DEBUG),
    run=_prefix,
)
EXECUTABLES = Command(
    "pkg executables",
    "list the executables of a package, or of all",
    arguments=(option("[PACKAGE]"),),
    options=(option("--full-path", "print their paths"), DEBUG),
    run=_executables,
)
XML = Command(
    "pkg xml",
    "print the package.xml of a package",
    arguments=(PACKAGE,),
    options=(option("-t, --tag TAG", "print the text of this tag only"), DEBUG),
    run=_xml,
)
