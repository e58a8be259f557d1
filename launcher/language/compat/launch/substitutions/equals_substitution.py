"""`launch.substitutions.equals_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "EqualsSubstitution": "launcher.language.substitutions.logic",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
