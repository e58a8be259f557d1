"""`launch.frontend.expose`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "action_parse_methods": "launcher.language.frontend_registry",
    "expose_action": "launcher.language.frontend_registry",
    "expose_substitution": "launcher.language.frontend_registry",
    "instantiate_action": "launcher.frontends.expose",
    "instantiate_substitution": "launcher.frontends.expose",
    "substitution_parse_methods": "launcher.language.frontend_registry",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
