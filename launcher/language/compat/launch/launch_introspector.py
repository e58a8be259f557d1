"""`launch.launch_introspector`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "LaunchIntrospector": "launcher.language.introspection",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
