"""`launch.substitutions.anon_name`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AnonName": "launcher.language.substitutions.names",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
