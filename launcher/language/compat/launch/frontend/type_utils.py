"""`launch.frontend.type_utils`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "get_data_type_from_identifier": "launcher.frontends.types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
