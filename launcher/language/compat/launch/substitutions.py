"""Re-exports of `launch.substitutions`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.substitutions.configuration import LaunchConfiguration
from launcher.language.substitutions.text import TextSubstitution

__all__ = ["LaunchConfiguration", "TextSubstitution"]

__getattr__ = refuse_unknown("launch.substitutions", __all__)
