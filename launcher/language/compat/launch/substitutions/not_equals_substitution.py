"""`launch.substitutions.not_equals_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "NotEqualsSubstitution": "launcher.language.substitutions.logic",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
