"""`launch_ros.actions`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.composition import ComposableNodeContainer, LoadComposableNodes
from launcher.language.ros.lifecycle import LifecycleNode, LifecycleTransition
from launcher.language.ros.node import Node
from launcher.language.ros.scope import (
    PushROSNamespace,
    SetParameter,
    SetParametersFromFile,
    SetRemap,
    SetROSLogDir,
    SetUseSimTime,
)
from launcher.language.ros.scope import (
    PushROSNamespace as PushRosNamespace,
)
from launcher.language.ros.timer import RosTimer
from launcher.language.ros.timer import RosTimer as ROSTimer

__all__ = [
    "ComposableNodeContainer",
    "LifecycleNode",
    "LifecycleTransition",
    "LoadComposableNodes",
    "Node",
    "PushROSNamespace",
    "PushRosNamespace",
    "ROSTimer",
    "RosTimer",
    "SetParameter",
    "SetParametersFromFile",
    "SetROSLogDir",
    "SetRemap",
    "SetUseSimTime",
]

__getattr__ = refuse_unknown("launch_ros.actions", __all__)
