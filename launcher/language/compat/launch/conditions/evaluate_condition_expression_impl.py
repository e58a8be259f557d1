"""`launch.conditions.evaluate_condition_expression_impl`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.conditions import evaluate_condition_expression

__all__ = ["evaluate_condition_expression"]

__getattr__ = refuse_unknown("launch.conditions.evaluate_condition_expression_impl", __all__)
