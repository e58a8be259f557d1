"""`launch.conditions.invalid_condition_expression_error`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "InvalidConditionExpressionError": "launcher.language.conditions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
