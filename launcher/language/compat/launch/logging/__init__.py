"""`launch.logging`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.log import (
    LaunchConfig,
    LaunchLogger,
    get_logger,
    get_output_loggers,
    launch_config,
    log_launch_config,
    reset,
)

__all__ = [
    "LaunchConfig",
    "LaunchLogger",
    "get_logger",
    "get_output_loggers",
    "launch_config",
    "log_launch_config",
    "reset",
]

__getattr__ = refuse_unknown("launch.logging", __all__)
