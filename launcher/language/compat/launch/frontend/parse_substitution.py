"""`launch.frontend.parse_substitution`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "parse_if_substitutions": "launcher.frontends.grammar_substitutions",
    "parse_substitution": "launcher.frontends.grammar_substitutions",
    "replace_escaped_characters": "launcher.frontends.grammar:unescape",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
