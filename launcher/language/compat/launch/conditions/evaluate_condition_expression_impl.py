"""`launch.conditions.evaluate_condition_expression_impl`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "evaluate_condition_expression": "launcher.language.conditions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
