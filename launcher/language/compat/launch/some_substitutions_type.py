"""`launch.some_substitutions_type`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "SomeSubstitutionsType": "launcher.language.some_types",
    "SomeSubstitutionsType_types_tuple": "launcher.language.utilities",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
