"""`launch.actions.replace_environment_variables`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import ReplaceEnvironmentVariables
from launcher.language.compat.names import refuse_unknown

__all__ = ["ReplaceEnvironmentVariables"]

__getattr__ = refuse_unknown("launch.actions.replace_environment_variables", __all__)
