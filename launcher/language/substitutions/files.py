"""Substitutions for paths, programs and the content of files."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable

from launcher.base import text_file
from launcher.language import launch_session
from launcher.language.class_tools import is_path
from launcher.language.diagnostics import ros2_quirks
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    MAX_TEXT,
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.substitutions.path_join_substitution")
class PathJoinSubstitution(Substitution):
    """Path components, joined as `pathlib.Path` does; a list among them is one component."""

    substitutions: list[list[Substitution]] = read_only()

    def __init__(self, substitutions: Iterable[Any]) -> None:
        if isinstance(substitutions, (str, Substitution)) or is_path(substitutions):
            substitutions = [substitutions]
        self.__substitutions = [normalize_to_list_of_substitutions(one) for one in substitutions]

    def __truediv__(self, additional_path: object) -> PathJoinSubstitution:
        """A path below; the items of a list are one component."""
        return PathJoinSubstitution([*self.substitutions, additional_path])

    def describe(self) -> str:
        components = ", ".join(map(describe_substitutions, self.substitutions))
        return f"PathJoinSubstitution('{components}')"

    def perform(self, context: LaunchContext) -> str:
        return _joined_path([perform_substitutions(context, one) for one in self.substitutions])


def _joined_path(parts: Iterable[str]) -> str:
    """`str(Path(*parts))`; pathlib, which takes 3 ms to import, is not used."""
    path = os.path.join("", *parts)
    is_double = path[:2] == "//" and path[2:3] != "/"
    root = "//" if is_double else "/" if path[:1] == "/" else ""
    return root + "/".join(name for name in path.split("/") if name not in ("", ".")) or "."


@public("launch.substitutions.path_substitution")
class PathSubstitution(PathJoinSubstitution):
    """A path that can be extended with `/`; the items of a list are components."""

    def __init__(self, path: Any) -> None:
        super().__init__(normalize_to_list_of_substitutions(path))


class _Directory(Substitution):
    """Base of substitutions for a folder; `/` gives a path in it."""

    def __truediv__(self, additional_path: object) -> PathJoinSubstitution:
        return PathJoinSubstitution([self, additional_path])


@public("launch.substitutions.this_launch_file")
class ThisLaunchFile(Substitution):
    """The path of the launch file that is being visited."""

    def describe(self) -> str:
        return "ThisLaunchFile()"

    def perform(self, context: LaunchContext) -> str:
        """The path; SubstitutionFailure outside of a launch file."""
        ros2_quirks.this_file_is_another(context, "ThisLaunchFile()", self._origin)
        return _local(context, "current_launch_file_path", "ThisLaunchFile")


@public("launch.substitutions.this_launch_file_dir")
class ThisLaunchFileDir(_Directory):
    """The folder of the launch file that is being visited."""

    def describe(self) -> str:
        return "ThisLaunchFileDir()"

    def perform(self, context: LaunchContext) -> str:
        """The folder; SubstitutionFailure outside of a launch file."""
        ros2_quirks.this_file_is_another(context, "ThisLaunchFileDir()", self._origin)
        return _local(context, "current_launch_file_directory", "ThisLaunchFileDir")


def _local(context: LaunchContext, key: str, name: str) -> str:
    value = context.get_locals_as_dict().get(key)
    if value is None:
        raise SubstitutionFailure(f"{name} used outside of a launch file (in a script)")
    return str(value)


@public("launch.substitutions.find_executable")
class FindExecutable(Substitution):
    """The path of a program on PATH."""

    name: list[Substitution] = read_only()

    def __init__(self, *, name: object) -> None:
        self.__name = normalize_to_list_of_substitutions(name)

    def describe(self) -> str:
        return f"FindExec({describe_substitutions(self.name)})"

    def perform(self, context: LaunchContext) -> str:
        """The path; SubstitutionFailure if there is no such program."""
        name = perform_substitutions(context, self.name)
        path = shutil.which(name, path=context.environment.get("PATH"))
        if path is None:
            raise SubstitutionFailure(f"executable '{name}' not found on the PATH")
        return path


@public("launch.substitutions.file_content")
class FileContent(Substitution):
    """The text of a file, as it is (a last newline included)."""

    path: list[Substitution] = read_only()

    def __init__(self, path: Any) -> None:
        self.__path = normalize_to_list_of_substitutions(path)

    def describe(self) -> str:
        return f"FileContent({describe_substitutions(self.path)})"

    def perform(self, context: LaunchContext) -> str:
        """The text; SubstitutionFailure if it cannot be read."""
        path = perform_substitutions(context, self.path)
        try:
            with open(path) as file:
                text = file.read(MAX_TEXT + 1)  # of a device it would never end
        except FileNotFoundError:
            raise SubstitutionFailure(f"File not found: {path}") from None
        except PermissionError:
            raise SubstitutionFailure(f"Permission denied: {path}") from None
        except Exception as error:
            raise SubstitutionFailure(f"Error reading file: {path}: {error}") from error
        if text_file.is_pointer(text):
            raise SubstitutionFailure(
                f"{text_file.pointer_sentence(path)} ({text_file.POINTER_HINT})"
            )
        return text


@public("launch.substitutions.launch_log_dir")
class LaunchLogDir(_Directory):
    """The folder of this run's log files."""

    def describe(self) -> str:
        return "LaunchLogDir()"

    def perform(self, context: LaunchContext) -> str:
        return launch_session.current().log_dir
