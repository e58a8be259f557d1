"""`launch.substitutions.local_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LocalSubstitution": "launcher.language.substitutions.configuration",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
