"""`launch_ros.descriptions`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.composition import ComposableNode
from launcher.language.ros.executable import RosExecutable
from launcher.language.ros.node_descriptions import Node, NodeTrait
from launcher.language.ros.parameter_descriptions import Parameter, ParameterFile, ParameterValue

__all__ = [
    "ComposableNode",
    "Node",
    "NodeTrait",
    "Parameter",
    "ParameterFile",
    "ParameterValue",
    "RosExecutable",
]

__getattr__ = refuse_unknown("launch_ros.descriptions", __all__)
