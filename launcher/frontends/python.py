"""Launch files of any kind at the command line's end: loading one, with errors for people."""

from __future__ import annotations

from launcher.errors import LaunchFileError
from launcher.language.description import LaunchDescription
from launcher.language.sources import get_launch_description_from_any_launch_file


class NoDescriptionError(LaunchFileError):
    """`generate_launch_description()` returned something else."""

    ros_type = "AttributeError"
    stage = "run"  # ROS 2 finds out when it looks at what it got


def load(path: str) -> LaunchDescription:
    """The description in the file; LaunchFileError with place and cause."""
    try:
        description = get_launch_description_from_any_launch_file(path)
    except (Exception, SystemExit) as error:
        from launcher.language import faults

        raise faults.explain(error, path) from _cause(error)
    if not isinstance(description, LaunchDescription):
        from launcher.language.entries import place_of_return

        place = place_of_return(path, "generate_launch_description")
        raise NoDescriptionError(
            f"generate_launch_description() returned {type(description).__name__}, "
            "not a LaunchDescription",
            where=f"{path}:1" if place is None else str(place),
            hint="end it with `return LaunchDescription([...])`",
        )
    return description


def _cause(error: BaseException) -> BaseException:
    return error.__cause__ or error
