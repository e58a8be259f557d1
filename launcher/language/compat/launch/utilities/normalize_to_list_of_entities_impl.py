"""`launch.utilities.normalize_to_list_of_entities_impl`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "normalize_to_list_of_entities": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
