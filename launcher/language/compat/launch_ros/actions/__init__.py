"""`launch_ros.actions`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ComposableNodeContainer": "launcher.language.ros.composition",
    "LifecycleNode": "launcher.language.ros.lifecycle",
    "LifecycleTransition": "launcher.language.ros.lifecycle",
    "LoadComposableNodes": "launcher.language.ros.composition",
    "Node": "launcher.language.ros.node",
    "PushROSNamespace": "launcher.language.ros.scope",
    "PushRosNamespace": "launcher.language.ros.scope:PushROSNamespace",
    "ROSTimer": "launcher.language.ros.timer:RosTimer",
    "RosTimer": "launcher.language.ros.timer",
    "SetParameter": "launcher.language.ros.scope",
    "SetParametersFromFile": "launcher.language.ros.scope",
    "SetROSLogDir": "launcher.language.ros.scope",
    "SetRemap": "launcher.language.ros.scope",
    "SetUseSimTime": "launcher.language.ros.scope",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
