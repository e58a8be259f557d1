"""`launch.substitutions.environment_variable`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.environment import EnvironmentVariable

__all__ = ["EnvironmentVariable"]

__getattr__ = refuse_unknown("launch.substitutions.environment_variable", __all__)
