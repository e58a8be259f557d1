"""Re-exports of `launch.frontend.parse_substitution`."""

from launcher.frontends.grammar import unescape as replace_escaped_characters
from launcher.frontends.grammar_substitutions import parse_if_substitutions, parse_substitution
from launcher.language.compat.names import refuse_unknown

__all__ = ["parse_if_substitutions", "parse_substitution", "replace_escaped_characters"]

__getattr__ = refuse_unknown("launch.frontend.parse_substitution", __all__)
