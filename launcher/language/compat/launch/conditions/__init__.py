"""`launch.conditions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "IfCondition": "launcher.language.conditions",
    "InvalidConditionExpressionError": "launcher.language.conditions",
    "LaunchConfigurationEquals": "launcher.language.conditions",
    "LaunchConfigurationNotEquals": "launcher.language.conditions",
    "UnlessCondition": "launcher.language.conditions",
    "evaluate_condition_expression": "launcher.language.conditions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
