"""Re-exports of `launch.conditions`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import IfCondition, UnlessCondition

__all__ = ["IfCondition", "UnlessCondition"]

__getattr__ = refuse_unknown("launch.conditions", __all__)
