"""`launch.some_actions_type`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SomeActionsType": "launcher.language.some_types",
    "SomeActionsType_types_tuple": "launcher.language.some_types",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
