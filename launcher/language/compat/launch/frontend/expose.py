"""Re-exports of `launch.frontend.expose`."""

from launcher.frontends.expose import instantiate_action, instantiate_substitution
from launcher.language.compat.names import refuse_unknown
from launcher.language.frontend_registry import (
    action_parse_methods,
    expose_action,
    expose_substitution,
    substitution_parse_methods,
)

__all__ = [
    "action_parse_methods",
    "expose_action",
    "expose_substitution",
    "instantiate_action",
    "instantiate_substitution",
    "substitution_parse_methods",
]

__getattr__ = refuse_unknown("launch.frontend.expose", __all__)
