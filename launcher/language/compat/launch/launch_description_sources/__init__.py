"""`launch.launch_description_sources`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.python_file import (
    InvalidPythonLaunchFileError,
    load_python_launch_file_as_module,
)
from launcher.language.sources import (
    AnyLaunchDescriptionSource,
    FrontendLaunchDescriptionSource,
    PythonLaunchDescriptionSource,
    get_launch_description_from_any_launch_file,
    get_launch_description_from_frontend_launch_file,
    get_launch_description_from_python_launch_file,
)
from launcher.language.sources import (
    InvalidLaunchFileError as InvalidFrontendLaunchFileError,
)

__all__ = [
    "AnyLaunchDescriptionSource",
    "FrontendLaunchDescriptionSource",
    "InvalidFrontendLaunchFileError",
    "InvalidPythonLaunchFileError",
    "PythonLaunchDescriptionSource",
    "get_launch_description_from_any_launch_file",
    "get_launch_description_from_frontend_launch_file",
    "get_launch_description_from_python_launch_file",
    "load_python_launch_file_as_module",
]

__getattr__ = refuse_unknown("launch.launch_description_sources", __all__)
