"""`launch_ros.utilities`: our vocabulary under ROS 2's name."""

from launcher.language.compat.names import refuse_unknown
from launcher.language.ros.component_parameters import to_parameters_list
from launcher.language.ros.names import (
    is_namespace_absolute,
    is_root_namespace,
    make_namespace_absolute,
    prefix_namespace,
)
from launcher.language.ros.parameter_values import (
    evaluate_parameter_dict,
    evaluate_parameters,
    normalize_parameter_dict,
    normalize_parameters,
)
from launcher.language.ros.parameter_values import (
    evaluate_parameter_dict as evaluate_parameters_dict,
)
from launcher.language.ros.parameter_values import (
    normalize_parameter_dict as normalize_parameters_dict,
)
from launcher.language.ros.remappings import normalize_remap_rule, normalize_remap_rules
from launcher.language.ros.tracking import add_node_name, get_node_name_count

__all__ = [
    "add_node_name",
    "evaluate_parameter_dict",
    "evaluate_parameters",
    "evaluate_parameters_dict",
    "get_node_name_count",
    "is_namespace_absolute",
    "is_root_namespace",
    "make_namespace_absolute",
    "normalize_parameter_dict",
    "normalize_parameters",
    "normalize_parameters_dict",
    "normalize_remap_rule",
    "normalize_remap_rules",
    "prefix_namespace",
    "to_parameters_list",
]

__getattr__ = refuse_unknown("launch_ros.utilities", __all__)
