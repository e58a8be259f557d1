"""`launch.substitutions.if_else_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "IfElseSubstitution": "launcher.language.substitutions.logic",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
