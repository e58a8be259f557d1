"""`launch.substitutions.anon_name`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.names import AnonName

__all__ = ["AnonName"]

__getattr__ = refuse_unknown("launch.substitutions.anon_name", __all__)
