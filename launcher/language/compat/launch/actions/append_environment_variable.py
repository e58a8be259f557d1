"""`launch.actions.append_environment_variable`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import AppendEnvironmentVariable
from launcher.language.compat.names import refuse_unknown

__all__ = ["AppendEnvironmentVariable"]

__getattr__ = refuse_unknown("launch.actions.append_environment_variable", __all__)
