"""`launch.some_entities_type`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SomeEntitiesType": "launcher.language.some_types",
    "SomeEntitiesType_types_tuple": "launcher.language.some_types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
