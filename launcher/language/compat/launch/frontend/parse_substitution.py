"""`launch.frontend.parse_substitution`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import borrow, refuse_unknown

parse_substitution = borrow("launcher.frontends.grammar_substitutions", "parse_substitution")
parse_if_substitutions = borrow(
    "launcher.frontends.grammar_substitutions", "parse_if_substitutions"
)

__all__ = ["parse_if_substitutions", "parse_substitution"]

__getattr__ = refuse_unknown("launch.frontend.parse_substitution", __all__)
