"""`launch_ros.utilities`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "add_node_name": "launcher.language.ros.tracking",
    "evaluate_parameter_dict": "launcher.language.ros.parameter_values",
    "evaluate_parameters": "launcher.language.ros.parameter_values",
    "evaluate_parameters_dict": "launcher.language.ros.parameter_values:evaluate_parameter_dict",
    "get_node_name_count": "launcher.language.ros.tracking",
    "is_namespace_absolute": "launcher.language.ros.names",
    "is_root_namespace": "launcher.language.ros.names",
    "make_namespace_absolute": "launcher.language.ros.names",
    "normalize_parameter_dict": "launcher.language.ros.parameter_values",
    "normalize_parameters": "launcher.language.ros.parameter_values",
    "normalize_parameters_dict": "launcher.language.ros.parameter_values:normalize_parameter_dict",
    "normalize_remap_rule": "launcher.language.ros.remappings",
    "normalize_remap_rules": "launcher.language.ros.remappings",
    "prefix_namespace": "launcher.language.ros.names",
    "to_parameters_list": "launcher.language.ros.component_parameters",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
