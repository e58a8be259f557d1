"""Settings for all ROS nodes of a scope: namespace, parameters, remappings, log folder."""

from __future__ import annotations

import os

from launcher.base.model.events import UseSimTime
from launcher.language.action import Action
from launcher.language.diagnostics import ros2_quirks
from launcher.language.frontend_registry import parsed
from launcher.language.launch_session import default_log_dir
from launcher.language.naming import public, read_only
from launcher.language.ros.node_and_topic_names import (
    NameValidationException,
    make_namespace_absolute,
    prefix_namespace,
    validate_namespace,
)
from launcher.language.ros.parameter_descriptions import ParameterValue
from launcher.language.ros.parameter_values import (
    evaluate_parameter_dict,
    normalize_parameter_dict,
)
from launcher.language.substitution import (
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.language.type_utils import (
    normalize_typed_substitution,
    perform_typed_substitution,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch_ros.actions.push_ros_namespace")
@parsed
class PushROSNamespace(Action):
    """Puts the nodes of the scope below a namespace; an absolute one replaces those outside."""

    namespace: list[Substitution] = read_only()

    def __init__(self, namespace: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__namespace = normalize_to_list_of_substitutions(namespace)

    def execute(self, context: LaunchContext) -> None:
        """SubstitutionFailure if the resulting namespace is invalid."""
        pushed = perform_substitutions(context, self.namespace)
        previous = context.launch_configurations.get("ros_namespace", None)
        namespace = make_namespace_absolute(prefix_namespace(previous, pushed))
        try:
            validate_namespace(str(namespace))
        except NameValidationException as error:
            raise SubstitutionFailure(
                "The resulting namespace is invalid: "
                f"[previous_namespace='{previous}', pushed_namespace='{pushed}']"
            ) from error
        context.launch_configurations["ros_namespace"] = namespace


def _shared_list(context: LaunchContext, key: str, action: Action) -> list[Any]:
    """The list of a key, created if needed; nested scopes share it, as in ROS 2."""
    shared: list[Any] = context.launch_configurations.setdefault(key, [])
    outer = getattr(context, "_outer_configuration", None)  # none: a context of somebody's test
    if outer is not None and outer(key) is shared:
        ros2_quirks.setting_leaks(context, type(action).__name__, action._origin)
    return shared


@public("launch_ros.actions.set_parameter")
@parsed
class SetParameter(Action):
    """Gives all nodes of the scope a parameter.

    As in ROS 2, it leaks out of a scoped group if a global parameter existed outside already.
    """

    def __init__(self, name: object, value: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        key = tuple(normalize_to_list_of_substitutions(name))
        self.__param_dict = normalize_parameter_dict({key: value})

    @property
    def name(self) -> Any:
        return next(iter(self.__param_dict.keys()))

    @property
    def value(self) -> Any:
        """The value, normalised."""
        return next(iter(self.__param_dict.values()))

    def execute(self, context: LaunchContext) -> None:
        evaluated = evaluate_parameter_dict(context, self.__param_dict)
        if isinstance(self.value, ParameterValue) and self.value.value_type is str:
            for name, text in evaluated.items():
                ros2_quirks.text_is_no_text(context, name, text, self._origin)
        _shared_list(context, "global_params", self).extend(evaluated.items())


@public("launch_ros.actions.set_parameters_from_file")
@parsed
class SetParametersFromFile(Action):
    """Gives all nodes of the scope a parameter file."""

    def __init__(self, filename: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._input_file = normalize_to_list_of_substitutions(filename)

    def execute(self, context: LaunchContext) -> None:
        filename = perform_substitutions(context, self._input_file)
        _shared_list(context, "global_params", self).append(filename)


@public("launch_ros.actions.set_remap")
@parsed
class SetRemap(Action):
    """Gives all nodes of the scope a remapping, before their own."""

    src: list[Substitution] = read_only()
    dst: list[Substitution] = read_only()

    def __init__(self, src: object, dst: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__src = normalize_to_list_of_substitutions(src)
        self.__dst = normalize_to_list_of_substitutions(dst)

    def execute(self, context: LaunchContext) -> None:
        rule = (perform_substitutions(context, self.src), perform_substitutions(context, self.dst))
        _shared_list(context, "ros_remaps", self).append(rule)


@public("launch_ros.actions.set_ros_log_dir")
@parsed
class SetROSLogDir(Action):
    """Sets the folder that the nodes of the scope log into; a relative one is below the current."""

    log_dir: list[Substitution] = read_only(of="__new_log_dir")

    def __init__(self, new_log_dir: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__new_log_dir = normalize_to_list_of_substitutions(new_log_dir)

    def execute(self, context: LaunchContext) -> None:
        # Absolute: processes may have another working directory.
        current = os.path.abspath(default_log_dir())
        folder = os.path.join(current, perform_substitutions(context, self.log_dir))
        context.environment["ROS_LOG_DIR"] = folder


@public("launch_ros.actions.set_use_sim_time")
@parsed
class SetUseSimTime(Action):
    """Makes timers of the launch file (RosTimer), not the nodes, follow simulated time.

    False makes them follow wall time again, with a warning: in ROS 2 it raises an error.
    """

    value: Any = read_only("True, false, or substitutions.")

    def __init__(self, value: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__value = normalize_typed_substitution(value, bool)

    def execute(self, context: LaunchContext) -> None:
        """ValueError if substitutions give something else."""
        value = perform_typed_substitution(context, self.value, bool)
        ros2_quirks.note_sim_time(context, value)
        host = getattr(context, "_host", None)  # none: a context of somebody's test
        if host is not None:
            host.request(UseSimTime(value=value))
            if not value:
                ros2_quirks.sim_time_is_off(context, self._origin)


@public("launch_ros.substitutions.parameter")
class Parameter(Substitution):
    """The value of a parameter that SetParameter gave to the scope."""

    name: list[Substitution] = read_only()
    default: list[Substitution] | None = read_only("Used if the parameter does not exist.")

    def __init__(self, name: object, *, default: object = None) -> None:
        self.__name = normalize_to_list_of_substitutions(name)
        self.__default = None if default is None else _default(default)

    def describe(self) -> str:
        return f"Parameter({describe_substitutions(self.name)})"

    def perform(self, context: LaunchContext) -> str:
        """The value as text, else the default; SubstitutionFailure without either."""
        name = perform_substitutions(context, self.name)
        for parameter in context.launch_configurations.get("global_params", None) or ():
            if isinstance(parameter, tuple) and parameter[0] == name:
                return str(parameter[1])
        if self.default is None:
            raise SubstitutionFailure(f"parameter '{name}' not found")
        return perform_substitutions(context, self.default)


def _default(default: object) -> list[Substitution]:
    items = default if isinstance(default, (list, tuple)) else [default]
    return normalize_to_list_of_substitutions(
        [item if isinstance(item, (str, Substitution)) else str(item) for item in items]
    )
