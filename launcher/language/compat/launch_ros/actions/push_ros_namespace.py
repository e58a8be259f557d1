"""`launch_ros.actions.push_ros_namespace`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "PushROSNamespace": "launcher.language.ros.scope",
    "PushRosNamespace": "launcher.language.ros.scope:PushROSNamespace",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
