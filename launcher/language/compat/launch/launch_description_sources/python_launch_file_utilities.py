"""`launch.launch_description_sources.python_launch_file_utilities`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.python_file import (
    InvalidPythonLaunchFileError,
    load_python_launch_file_as_module,
)
from launcher.language.sources import get_launch_description_from_python_launch_file

__all__ = [
    "InvalidPythonLaunchFileError",
    "get_launch_description_from_python_launch_file",
    "load_python_launch_file_as_module",
]

__getattr__ = refuse_unknown(
    "launch.launch_description_sources.python_launch_file_utilities", __all__
)
