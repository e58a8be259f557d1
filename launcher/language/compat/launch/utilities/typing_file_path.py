"""`launch.utilities.typing_file_path`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.utilities import FilePath

__all__ = ["FilePath"]

__getattr__ = refuse_unknown("launch.utilities.typing_file_path", __all__)
