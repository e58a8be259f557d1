"""`launch.actions.unset_environment_variable`: our vocabulary under ROS 2's name."""

from launcher.language.actions.configuration import UnsetEnvironmentVariable
from launcher.language.compat.names import refuse_unknown

__all__ = ["UnsetEnvironmentVariable"]

__getattr__ = refuse_unknown("launch.actions.unset_environment_variable", __all__)
