"""`launch.events.process.process_targeted_event`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.process_events import ProcessTargetedEvent

__all__ = ["ProcessTargetedEvent"]

__getattr__ = refuse_unknown("launch.events.process.process_targeted_event", __all__)
