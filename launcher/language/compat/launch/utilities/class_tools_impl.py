"""`launch.utilities.class_tools_impl`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "is_a": "launcher.language.utilities",
    "is_a_subclass": "launcher.language.utilities",
    "isclassinstance": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
