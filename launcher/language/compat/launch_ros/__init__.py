"""Re-exports of `launch_ros`."""

from launcher.language.compat.names import refuse_unknown

__all__ = []

__getattr__ = refuse_unknown("launch_ros", __all__)
