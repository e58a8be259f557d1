"""`launch.utilities.visit_all_entities_and_collect_futures_impl`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "visit_all_entities_and_collect_futures": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
