"""`launch.substitutions.path_join_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "PathJoinSubstitution": "launcher.language.substitutions.files",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
