"""`launch.conditions.invalid_condition_expression_error`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import InvalidConditionExpressionError

__all__ = ["InvalidConditionExpressionError"]

__getattr__ = refuse_unknown("launch.conditions.invalid_condition_expression_error", __all__)
