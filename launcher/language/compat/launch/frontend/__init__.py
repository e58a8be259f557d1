"""Re-exports of `launch.frontend`."""

from launcher.frontends.entity import Entity
from launcher.frontends.grammar_substitutions import parse_substitution
from launcher.frontends.parser import InvalidFrontendLaunchFileError, Parser
from launcher.language.compat.names import refuse_unknown
from launcher.language.frontend_registry import expose_action, expose_substitution

__all__ = [
    "Entity",
    "InvalidFrontendLaunchFileError",
    "Parser",
    "expose_action",
    "expose_substitution",
    "parse_substitution",
]

__getattr__ = refuse_unknown("launch.frontend", __all__)
