"""`launch.substitutions.python_expression`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "PythonExpression": "launcher.language.substitutions.python",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
