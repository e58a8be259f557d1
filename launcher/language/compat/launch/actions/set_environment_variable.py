"""`launch.actions.set_environment_variable`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import SetEnvironmentVariable
from launcher.language.compat.names import refuse_unknown

__all__ = ["SetEnvironmentVariable"]

__getattr__ = refuse_unknown("launch.actions.set_environment_variable", __all__)
