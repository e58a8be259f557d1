"""`launch.frontend`, re-exported."""

from launcher.language.compat.names import reexport

from . import parse_substitution

# The function of this name is what users want; a module that is loaded already does not hide it.
del parse_substitution

_SOURCES = {
    "Entity": "launcher.frontends.entity",
    "InvalidFrontendLaunchFileError": "launcher.frontends.parser",
    "Parser": "launcher.frontends.parser",
    "expose_action": "launcher.language.frontend_registry",
    "expose_substitution": "launcher.language.frontend_registry",
    "parse_if_substitutions": "launcher.frontends.grammar_substitutions",
    "parse_substitution": "launcher.frontends.grammar_substitutions",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
