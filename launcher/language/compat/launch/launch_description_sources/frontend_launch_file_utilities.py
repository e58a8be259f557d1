"""`launch.launch_description_sources.frontend_launch_file_utilities`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.sources import get_launch_description_from_frontend_launch_file

__all__ = ["get_launch_description_from_frontend_launch_file"]

__getattr__ = refuse_unknown(
    "launch.launch_description_sources.frontend_launch_file_utilities", __all__
)
