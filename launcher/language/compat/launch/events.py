"""Re-exports of `launch.events`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.events import Shutdown, matches_action

__all__ = ["Shutdown", "matches_action"]

__getattr__ = refuse_unknown("launch.events", __all__)
