"""`launch.frontend.type_utils`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "check_is_list_entity": "launcher.frontends.types:is_entity_list",
    "get_data_type_from_identifier": "launcher.frontends.types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
