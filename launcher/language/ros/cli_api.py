"""What launch files import from `ros2pkg.api` and `ros2launch.api`."""

from __future__ import annotations

import os
from collections.abc import Iterable, KeysView

from launcher.base.errors import PackageNotFoundError
from launcher.language.naming import public
from launcher.language.ros.packages import FindPackageShare
from launcher.packages import finder

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.description import LaunchDescription

# ---- ros2pkg.api


@public("ros2pkg.api")
class PackageNotFound(Exception):
    """There is no package of this name."""

    def __init__(self, package_name: str) -> None:
        super().__init__(package_name)
        self.package_name = package_name


def get_package_names() -> KeysView[str]:
    """The names of all packages."""
    return dict.fromkeys(sorted(finder.package_names(os.environ))).keys()


def package_name_completer(**named: object) -> KeysView[str]:
    """The names of all packages, for argcomplete."""
    return get_package_names()


def get_prefix_path(package_name: str) -> str | None:
    """The prefix that a package is installed in; None if it is not found."""
    try:
        return str(finder.package_prefix(package_name, os.environ))
    except PackageNotFoundError:
        return None


def get_executable_paths(*, package_name: str) -> list[str]:
    """The paths of the executables of a package; PackageNotFound."""
    prefix = get_prefix_path(package_name)
    if prefix is None:
        raise PackageNotFound(package_name)
    paths: list[str] = []
    for folder, below, files in os.walk(os.path.join(prefix, "lib", package_name)):
        below[:] = sorted(name for name in below if not name.startswith("."))
        paths += (os.path.join(folder, name) for name in sorted(files))
    found = [path for path in paths if os.access(path, os.X_OK)]
    if found:
        return found
    # A package that pip has installed: its programs are in `bin`.
    return [str(path) for path in finder.executable_paths(package_name, os.environ).values()]


# ---- ros2launch.api


@public("ros2launch.api.api")
class MultipleLaunchFilesError(Exception):
    """Several files of a package have the name; `paths` are theirs."""

    def __init__(self, msg: str, paths: list[str]) -> None:
        super().__init__(msg)
        self.paths = paths


def get_share_file_path_from_package(*, package_name: str, file_name: str) -> str:
    """The path of the file of this name in the share folder of a package, at any depth.

    Raises PackageNotFoundError, FileNotFoundError or MultipleLaunchFilesError.
    """
    share = FindPackageShare.find(package_name)
    found = [path for path in finder.files_in_share(share) if os.path.basename(path) == file_name]
    where = f"in the share directory of package '{package_name}'"
    if not found:
        raise FileNotFoundError(f"file '{file_name}' was not found {where} which is at '{share}'")
    if len(found) > 1:
        raise MultipleLaunchFilesError(
            f"file '{file_name}' was found more than once {where}: {found}", found
        )
    return found[0]


def is_launch_file(path: str) -> bool:
    """Whether the path is a file with the suffix of launch files."""
    return path.endswith(_EXTENSIONS) and os.path.isfile(path)


_EXTENSIONS = ("launch.xml", "launch.yaml", "launch.yml", "launch.py")
is_launch_file.extensions = _EXTENSIONS  # type: ignore[attr-defined]


def get_launch_file_paths(*, path: str) -> list[str]:
    """The launch files below a folder."""
    return [file for file in finder.files_in_share(path) if is_launch_file(file)]


def parse_launch_arguments(launch_arguments: Iterable[str]) -> Any:
    """The items of `name:=value` words, the last value of each name; RuntimeError."""
    values: dict[str, str] = {}
    for argument in launch_arguments:
        name, separator, value = argument.partition(":=")
        if not (separator and name and value):
            raise RuntimeError(
                f"malformed launch argument '{argument}', expected format '<name>:=<value>'"
            )
        values[name] = value
    return values.items()


def print_a_launch_file(*, launch_file_path: str) -> None:
    """Print the description of a launch file."""
    from launcher.language.introspection import LaunchIntrospector

    print(LaunchIntrospector().format_launch_description(_description_of(launch_file_path)))


def print_arguments_of_launch_file(*, launch_file_path: str) -> None:
    """Print the arguments of a launch file."""
    print_arguments_of_launch_description(launch_description=_description_of(launch_file_path))


def print_arguments_of_launch_description(*, launch_description: LaunchDescription) -> None:
    """Print the arguments of a description."""
    print("Arguments (pass arguments as '<name>:=<value>'):")
    arguments = launch_description.get_launch_arguments()
    for argument in arguments:
        star = "*" if argument._conditionally_included else ""
        print(f"\n    '{argument.name}':{star}\n        {argument.description}")
        if argument.default_value is not None:
            default = " + ".join(token.describe() for token in argument.default_value)
            print(f"        (default: {default})")
    if not arguments:
        print("\n  No arguments.")
    elif any(argument._conditionally_included for argument in arguments):
        print("\n* argument(s) which are only used if specific conditions occur")


def launch_a_launch_file(
    *,
    launch_file_path: str,
    launch_file_arguments: Iterable[str],
    noninteractive: bool = False,
    debug: bool = False,
    args: object = None,
    option_extensions: object = None,
) -> Any:
    """Run a launch file with `name:=value` words by a LaunchService; its exit code."""
    from launcher.language.actions.include import IncludeLaunchDescription
    from launcher.language.description import LaunchDescription
    from launcher.language.service import LaunchService
    from launcher.language.sources import AnyLaunchDescriptionSource

    words = list(launch_file_arguments)
    service = LaunchService(argv=words, noninteractive=noninteractive, debug=debug)
    include = IncludeLaunchDescription(
        AnyLaunchDescriptionSource(launch_file_path),
        launch_arguments=parse_launch_arguments(words),
    )
    service.include_launch_description(LaunchDescription([include]))
    return service.run()


def _description_of(path: str) -> LaunchDescription:
    from launcher.language.sources import get_launch_description_from_any_launch_file

    description: LaunchDescription = get_launch_description_from_any_launch_file(path)
    return description


class LaunchFileNameCompleter:
    """Returns the names of the launch files of a package, for argcomplete."""

    def __init__(self, *, package_name_key: str | None = None) -> None:
        self.package_name_key = package_name_key or "package_name"

    def __call__(self, prefix: str, parsed_args: object, **named: object) -> list[str]:
        package = getattr(parsed_args, self.package_name_key)
        try:
            share = finder.share_directory(package, os.environ)
        except PackageNotFoundError:
            return []
        return [os.path.basename(path) for path in get_launch_file_paths(path=str(share))]
