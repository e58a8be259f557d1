"""`launch.substitutions.file_content`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.files import FileContent

__all__ = ["FileContent"]

__getattr__ = refuse_unknown("launch.substitutions.file_content", __all__)
