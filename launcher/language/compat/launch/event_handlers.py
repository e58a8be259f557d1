"""Re-exports of `launch.event_handlers`."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.handlers import OnProcessExit, OnProcessStart, OnShutdown

__all__ = ["OnProcessExit", "OnProcessStart", "OnShutdown"]

__getattr__ = refuse_unknown("launch.event_handlers", __all__)
