"""Substitutions that find packages and the executables in them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from launcher.base.errors import ExecutableNotFoundError, PackageNotFoundError
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.packages import finder

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.substitutions.files import PathJoinSubstitution


def missing(error: PackageNotFoundError, name: str) -> PackageNotFoundError:
    """The error as launch files expect it: also ament_index_python's exception, or KeyError."""
    try:
        from ament_index_python.packages import PackageNotFoundError as AmentError
    except ImportError:
        AmentError = KeyError
    from launcher.packages.overlay import without_overlays

    kind = type("PackageNotFoundError", (PackageNotFoundError, AmentError), {})
    value = without_overlays(os.environ.get("AMENT_PREFIX_PATH", ""))
    prefixes = [p for p in value.split(os.pathsep) if p]
    found: PackageNotFoundError = kind(error.message, hint=error.hint)
    found.args = (f"package '{name}' not found, searching: {prefixes}",)
    return found


class IllFormedNameError(PackageNotFoundError, ValueError):
    """An invalid package name: ROS 2's ValueError, with a hint."""

    ros_type = "ValueError"


def _check_package_name(name: str) -> None:
    # REP 127 with the exceptions that it recommends
    if not re.fullmatch(r"[a-zA-Z0-9][a-zA-Z0-9_-]+", name, re.ASCII):
        raise IllFormedNameError(
            f"'{name}' is not a valid package name",
            hint="use two or more letters, digits, '_' or '-', and begin with a letter or a digit",
        )


def _find(look_up: Callable[[str, Mapping[str, str]], Path], name: str) -> str:
    _check_package_name(name)
    try:
        return str(look_up(name, os.environ))
    except PackageNotFoundError as error:
        raise missing(error, name) from None


@public("launch_ros.substitutions.find_package")
class FindPackage(Substitution):
    """Base of substitutions that find a package; subclasses override the static `find`.

    They can be extended with `/`.
    """

    package: list[Substitution] = read_only()

    def __init__(self, package: Any) -> None:
        self.__package = normalize_to_list_of_substitutions(package)

    def __truediv__(self, additional_path: Any) -> PathJoinSubstitution:
        from launcher.language.substitutions.files import PathJoinSubstitution

        return PathJoinSubstitution([self, additional_path])

    @classmethod
    def parse(cls, data: Any) -> Any:
        """(class, keyword arguments) of `$(find-pkg-... name)`."""
        if not data or len(data) != 1:
            raise AttributeError("find package substitutions expect 1 argument")
        return cls, {"package": data[0]}

    @staticmethod
    def find(package_name: str) -> str:
        raise NotImplementedError()

    def describe(self) -> str:
        package = describe_substitutions(self.package)
        return f"{self.__class__.__name__}(pkg={package})"

    def perform(self, context: LaunchContext) -> str:
        """The path; PackageNotFoundError if there is no such package."""
        return self.find(perform_substitutions(context, self.package))


@public("launch_ros.substitutions.find_package")
class FindPackagePrefix(FindPackage):
    """The prefix that a package is installed in."""

    @staticmethod
    def find(package_name: str) -> str:
        return _find(finder.package_prefix, package_name)


@public("launch_ros.substitutions.find_package")
class FindPackageShare(FindPackage):
    """The share folder of a package."""

    @staticmethod
    def find(package_name: str) -> str:
        return _find(finder.share_directory, package_name)


class ExecutableMissing(SubstitutionFailure, ExecutableNotFoundError):
    """The package has no such executable: ROS 2's failure, with a hint."""

    ros_type = "SubstitutionFailure"

    def __init__(self, error: ExecutableNotFoundError) -> None:
        ExecutableNotFoundError.__init__(self, error.message, hint=error.hint)


def _executable_path(package: str, executable: str) -> str:
    """The path of an executable given with a folder: as in ROS 2, not searched in the package."""
    libexec = finder.package_prefix(package, os.environ) / "lib" / package
    if libexec.is_dir() and os.path.isfile(executable) and os.access(executable, os.X_OK):
        return executable
    raise ExecutableNotFoundError(
        f"executable '{executable}' not found on the libexec directory '{libexec}'",
        hint="ROS 2 expects the name of a program in that folder, without a slash",
    )


@public("launch_ros.substitutions.executable_in_package")
class ExecutableInPackage(FindPackagePrefix):
    """The path of an executable of a package."""

    executable: list[Substitution] = read_only()

    def __init__(self, executable: object, package: Any) -> None:
        super().__init__(package)
        self.__executable = normalize_to_list_of_substitutions(executable)
        # (package, executable) of the last `perform`, for plans.
        self._found: tuple[str, str] | None = None

    @classmethod
    def parse(cls, data: Any) -> Any:
        """(class, keyword arguments) of `$(exec-in-pkg executable package)`."""
        if not data or len(data) != 2:
            raise AttributeError("exec-in-pkg substitution expects 2 arguments")
        return cls, {"executable": data[0], "package": data[1]}

    def describe(self) -> str:
        executable = describe_substitutions(self.executable)
        package = describe_substitutions(self.package)
        return f"ExecInPkg(pkg={package}, exec={executable})"

    def perform(self, context: LaunchContext) -> str:
        """The path; PackageNotFoundError or SubstitutionFailure."""
        executable = perform_substitutions(context, self.executable)
        package = perform_substitutions(context, self.package)
        self._found = (package, executable)
        _check_package_name(package)
        try:
            if os.path.dirname(executable):
                return _executable_path(package, executable)
            path: Path = finder.find_executable(package, executable, os.environ)
        except PackageNotFoundError as error:
            raise missing(error, package) from None
        except ExecutableNotFoundError as error:
            raise ExecutableMissing(error) from None
        return str(path)
