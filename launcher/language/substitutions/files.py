"""Substitutions for paths, programs and the content of files."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable

from launcher.language import session
from launcher.language.diagnostics import ros2_quirks
from launcher.language.naming import public
from launcher.language.substitution import (
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
    """Path components, joined as `os.path.join` does."""

    def __init__(self, substitutions: Iterable[Any]) -> None:
        self.__substitutions = normalize_to_list_of_substitutions(substitutions)

    @property
    def substitutions(self) -> list[Substitution]:
        return self.__substitutions

    def describe(self) -> str:
        return f"PathJoin('{describe_substitutions(self.substitutions)}')"

    def perform(self, context: LaunchContext) -> str:
        return os.path.join(*[sub.perform(context) for sub in self.substitutions])


@public("launch.substitutions.path_substitution")
class PathSubstitution(PathJoinSubstitution):
    """A path that can be extended with `/` (newer than Jazzy)."""

    def __init__(self, path: Any) -> None:
        super().__init__([_component(path)])

    def __truediv__(self, additional_path: Any) -> PathSubstitution:
        extended = PathSubstitution("")
        parts = [*self.substitutions, _component(additional_path)]
        extended.substitutions[:] = normalize_to_list_of_substitutions(parts)
        return extended


def _component(path: Any) -> str | Substitution:
    return path if isinstance(path, (str, Substitution)) else _Joined(path)


class _Joined(Substitution):
    """Several substitutions as one path component."""

    def __init__(self, parts: Any) -> None:
        self._parts = normalize_to_list_of_substitutions(parts)

    def perform(self, context: LaunchContext) -> str:
        return perform_substitutions(context, self._parts)


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
class ThisLaunchFileDir(Substitution):
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

    def __init__(self, *, name: Any) -> None:
        self.__name = normalize_to_list_of_substitutions(name)

    @property
    def name(self) -> list[Substitution]:
        return self.__name

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

    def __init__(self, path: Any) -> None:
        self.__path = normalize_to_list_of_substitutions(path)

    @property
    def path(self) -> list[Substitution]:
        return self.__path

    def describe(self) -> str:
        return f"FileContent({describe_substitutions(self.path)})"

    def perform(self, context: LaunchContext) -> str:
        """The text; SubstitutionFailure if it cannot be read."""
        path = perform_substitutions(context, self.path)
        try:
            with open(path) as file:
                return file.read()
        except FileNotFoundError:
            raise SubstitutionFailure(f"File not found: {path}") from None
        except PermissionError:
            raise SubstitutionFailure(f"Permission denied: {path}") from None
        except Exception as error:
            raise SubstitutionFailure(f"Error reading file: {path}: {error}") from error


@public("launch.substitutions.launch_log_dir")
class LaunchLogDir(Substitution):
    """The folder of this run's log files."""

    def describe(self) -> str:
        return "LaunchLogDir()"

    def perform(self, context: LaunchContext) -> str:
        return session.current().log_dir
