"""`launch.substitutions.boolean_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AllSubstitution": "launcher.language.substitutions.logic",
    "AndSubstitution": "launcher.language.substitutions.logic",
    "AnySubstitution": "launcher.language.substitutions.logic",
    "NotSubstitution": "launcher.language.substitutions.logic",
    "OrSubstitution": "launcher.language.substitutions.logic",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
