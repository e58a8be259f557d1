"""`launch.actions.timer_action`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "TimerAction": "launcher.language.actions.timer",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
