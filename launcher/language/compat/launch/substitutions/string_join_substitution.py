"""`launch.substitutions.string_join_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "StringJoinSubstitution": "launcher.language.substitutions.text",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
