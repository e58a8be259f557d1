"""`launch.substitutions.text_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "TextSubstitution": "launcher.language.substitutions.text",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
