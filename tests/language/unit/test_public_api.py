"""The public API of launch and launch_ros: every name is there, with the real signature.

A signature reads like Python's, without annotations; `name=` has a default.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from typing import Any

import pytest

from launcher.language.compat import (
    TOP_NAMES,
    compat_table,
    launch_test_table,
    tool_table,
    vocabulary,
)
from launcher.language.compat.names import TOOL_NAMES
from launcher.language.naming import read_only

PUBLIC_MODULES = {
    module
    for table in (compat_table, launch_test_table, tool_table)
    for module in (
        *table.MODULES,
        *(f"{package}.{name}" for package, names in table.SUBMODULES.items() for name in names),
    )
}

SIGNATURES = {
    "launch": {
        "Action": "*, condition=",
        "Condition": "*, predicate=",
        "Event": "",
        "EventHandler": "*, matcher, entities=, handle_once=",
        "InvalidLaunchFileError": "extension=, *, likely_errors=",
        "LaunchContext": "*, argv=, noninteractive=",
        "LaunchDescription": "initial_entities=, *, deprecated_reason=",
        "LaunchDescriptionEntity": "",
        "LaunchDescriptionSource": "launch_description=, location=, method=",
        "LaunchIntrospector": "",
        "LaunchService": "*, argv=, noninteractive=, debug=, log_file_name=",
        "Substitution": "",
    },
    "launch.actions": {
        "AppendEnvironmentVariable": "name, value, prepend=, separator=, **kwargs",
        "DeclareBooleanLaunchArgument": "name, *, default_value=, **kwargs",
        "DeclareLaunchArgument": "name, *, default_value=, description=, choices=, **kwargs",
        "EmitEvent": "*, event, **kwargs",
        "ExecuteLocal": (
            "*, process_description, shell=, sigterm_timeout=, sigkill_timeout=, "
            "emulate_tty=, output=, output_format=, cached_output=, log_cmd=, on_exit=, "
            "respawn=, respawn_delay=, respawn_max_retries=, **kwargs"
        ),
        "ExecuteProcess": "*, cmd, prefix=, name=, cwd=, env=, additional_env=, **kwargs",
        "ForEach": "input_values, *, function=, **kwargs",
        "ForLoop": "length, *, function=, name=, **kwargs",
        "GroupAction": (
            "actions, *, scoped=, forwarding=, launch_configurations=, **left_over_kwargs"
        ),
        "IncludeLaunchDescription": "launch_description_source, *, launch_arguments=, **kwargs",
        "Log": "*, msg, level, **kwargs",
        "LogDebug": "*, msg, **kwargs",
        "LogError": "*, msg, **kwargs",
        "LogInfo": "*, msg, **kwargs",
        "LogWarning": "*, msg, **kwargs",
        "OpaqueCoroutine": "*, coroutine, args=, kwargs=, ignore_context=, **left_over_kwargs",
        "OpaqueFunction": "*, function, args=, kwargs=, **left_over_kwargs",
        "PopEnvironment": "**kwargs",
        "PopLaunchConfigurations": "**kwargs",
        "PushEnvironment": "**kwargs",
        "PushLaunchConfigurations": "**kwargs",
        "RegisterEventHandler": "event_handler, **kwargs",
        "ReplaceEnvironmentVariables": "environment=, **kwargs",
        "ResetEnvironment": "**kwargs",
        "ResetLaunchConfigurations": "launch_configurations=, **kwargs",
        "SetEnvironmentVariable": "name, value, **kwargs",
        "SetLaunchConfiguration": "name, value, **kwargs",
        "Shutdown": "*, reason=, **kwargs",
        "TimerAction": "*, period, actions, cancel_on_shutdown=, **kwargs",
        "UnregisterEventHandler": "event_handler, **kwargs",
        "UnsetEnvironmentVariable": "name, **kwargs",
        "UnsetLaunchConfiguration": "name, **kwargs",
    },
    "launch.substitutions": {
        "AllSubstitution": "*args, container=",
        "AndSubstitution": "left, right",
        "AnonName": "name",
        "AnySubstitution": "*args, container=",
        "Command": "command, *, on_stderr=",
        "EnvironmentVariable": "name, *, default_value=",
        "EqualsSubstitution": "left, right",
        "FileContent": "path",
        "FindExecutable": "*, name",
        "ForEachVar": "name, *, default_value=",
        "ForLoopIndex": "name",
        "IfElseSubstitution": "condition, if_value=, else_value=",
        "LaunchConfiguration": "variable_name, *, default=",
        "LaunchLogDir": "",
        "LocalSubstitution": "expression, description=",
        "NotEqualsSubstitution": "left, right",
        "NotSubstitution": "value",
        "OrSubstitution": "left, right",
        "PathJoinSubstitution": "substitutions",
        "PathSubstitution": "path",
        "PythonExpression": "expression, python_modules=",
        "StringJoinSubstitution": "substitutions, delimiter=",
        "TextSubstitution": "*, text",
        "ThisLaunchFile": "",
        "ThisLaunchFileDir": "",
    },
    "launch.conditions": {
        "IfCondition": "predicate_expression",
        "LaunchConfigurationEquals": "launch_configuration_name, expected_value",
        "LaunchConfigurationNotEquals": "launch_configuration_name, expected_value",
        "UnlessCondition": "predicate_expression",
        "evaluate_condition_expression": "context, expression",
    },
    "launch.events": {
        "ExecutionComplete": "*, action",
        "IncludeLaunchDescription": "launch_description",
        "Shutdown": "*, reason=, due_to_sigint=",
        "TimerEvent": "*, timer_action",
        "matches_action": "target_action",
    },
    "launch.events.process": {
        "ProcessExited": "*, returncode, **kwargs",
        "ProcessIO": "*, text, fd, **kwargs",
        "ProcessStarted": "*, action, name, cmd, cwd, env, pid, **kwargs",
        "ProcessStderr": "*, text, **kwargs",
        "ProcessStdin": "*, text, **kwargs",
        "ProcessStdout": "*, text, **kwargs",
        "ProcessTargetedEvent": "*, process_matcher",
        "RunningProcessEvent": "*, action, name, cmd, cwd, env, pid, **kwargs",
        "ShutdownProcess": "*, process_matcher",
        "SignalProcess": "*, signal_number, process_matcher",
        "matches_executable": "executable",
        "matches_name": "name",
        "matches_pid": "pid",
    },
    "launch.event_handlers": {
        "OnActionEventBase": (
            "*, action_matcher, on_event, target_event_cls, target_action_cls, **kwargs"
        ),
        "OnExecutionComplete": "*, target_action=, on_completion, **kwargs",
        "OnIncludeLaunchDescription": "**kwargs",
        "OnProcessExit": "*, target_action=, on_exit, **kwargs",
        "OnProcessIO": "*, target_action=, on_stdin=, on_stdout=, on_stderr=, **kwargs",
        "OnProcessStart": "*, target_action=, on_start, **kwargs",
        "OnShutdown": "*, on_shutdown, **kwargs",
        "event_named": "name",
    },
    "launch.descriptions": {
        "Executable": "*, cmd, prefix=, name=, cwd=, env=, additional_env=, arguments=",
    },
    "launch.launch_description_sources": {
        "AnyLaunchDescriptionSource": "launch_file_path",
        "FrontendLaunchDescriptionSource": "launch_file_path, *, method=, parser=",
        "InvalidFrontendLaunchFileError": "extension=, *, likely_errors=",
        "PythonLaunchDescriptionSource": "launch_file_path",
        "get_launch_description_from_any_launch_file": "launch_file_path, *, parser=",
        "get_launch_description_from_frontend_launch_file": "launch_file_path, *, parser=",
        "get_launch_description_from_python_launch_file": "python_launch_file_path",
        "load_python_launch_file_as_module": "python_launch_file_path",
    },
    "launch.event_handler": {
        "BaseEventHandler": "*, matcher, handle_once=",
        "EventHandler": "*, matcher, entities=, handle_once=",
    },
    "launch_ros.actions": {
        "ComposableNodeContainer": "*, name, namespace, composable_node_descriptions=, **kwargs",
        "LifecycleNode": "*, name, namespace, autostart=, **kwargs",
        "LifecycleTransition": "*, lifecycle_node_names, transition_ids, **kwargs",
        "LoadComposableNodes": "*, composable_node_descriptions, target_container, **kwargs",
        "Node": (
            "*, executable, package=, name=, namespace=, exec_name=, parameters=, "
            "remappings=, ros_arguments=, arguments=, **kwargs"
        ),
        "PushROSNamespace": "namespace, **kwargs",
        "PushRosNamespace": "namespace, **kwargs",
        "ROSTimer": "*, period, actions, **kwargs",
        "RosTimer": "*, period, actions, **kwargs",
        "SetParameter": "name, value, **kwargs",
        "SetParametersFromFile": "filename, **kwargs",
        "SetROSLogDir": "new_log_dir, **kwargs",
        "SetRemap": "src, dst, **kwargs",
        "SetUseSimTime": "value, **kwargs",
    },
    "launch_ros.substitutions": {
        "ExecutableInPackage": "executable, package",
        "FindPackage": "package",
        "FindPackagePrefix": "package",
        "FindPackageShare": "package",
        "Parameter": "name, *, default=",
    },
    "launch_ros.descriptions": {
        "ComposableLifecycleNode": "*, autostart=, **kwargs",
        "ComposableNode": (
            "*, package, plugin, name=, namespace=, parameters=, remappings=, "
            "extra_arguments=, condition="
        ),
        "Node": (
            "*, node_name=, node_namespace=, original_node_name=, parameters=, remappings=, "
            "arguments=, traits=, **kwargs"
        ),
        "NodeTrait": "",
        "Parameter": "name, value, *, value_type=",
        "ParameterFile": "param_file, *, allow_substs=",
        "ParameterValue": "value, *, value_type=",
        "RosExecutable": "*, executable=, package=, nodes=, **kwargs",
    },
    "launch_ros.parameter_descriptions": {
        "Parameter": "name, value, *, value_type=",
        "ParameterFile": "param_file, *, allow_substs=",
        "ParameterValue": "value, *, value_type=",
    },
    "launch_ros.events.lifecycle": {
        "ChangeState": "*, lifecycle_node_matcher, transition_id",
        "StateTransition": "*, action, msg",
        "matches_node_name": "node_name",
    },
    "launch_ros.event_handlers": {
        "OnStateTransition": (
            "*, entities, target_lifecycle_node=, transition=, start_state=, goal_state=, "
            "matcher=, **kwargs"
        ),
    },
    "launch.utilities": {
        "create_future": "loop",
        "ensure_argument_type": "argument, types, argument_name, caller=",
        "get_signal_name": "signal_number",
        "is_a": "obj, entity_type",
        "is_a_subclass": "obj, entity_type",
        "isclassinstance": "obj",
        "normalize_to_list_of_entities": "entities",
        "normalize_to_list_of_substitutions": "subs",
        "perform_substitutions": "context, subs",
        "visit_all_entities_and_collect_futures": "entity, context",
    },
    "launch_ros.utilities": {
        "LifecycleEventManager": "lifecycle_node",
        "add_node_name": "context, node_name",
        "evaluate_parameter_dict": "context, parameters",
        "evaluate_parameters": "context, parameters",
        "evaluate_parameters_dict": "context, parameters",
        "get_node_name_count": "context, node_name",
        "is_namespace_absolute": "ns",
        "is_root_namespace": "ns",
        "make_namespace_absolute": "ns",
        "normalize_parameter_dict": "parameters, *, _prefix=",
        "normalize_parameters": "parameters",
        "normalize_parameters_dict": "parameters, *, _prefix=",
        "normalize_remap_rule": "remap_rule",
        "normalize_remap_rules": "remap_rules",
        "prefix_namespace": "base_ns, ns",
        "to_parameters_list": "context, node_name, namespace, evaluated_parameters",
    },
    "launch.utilities.type_utils": {
        "coerce_list": "value, data_type=, can_be_str=",
        "coerce_to_type": "value, data_type=, can_be_str=",
        "extract_type": "data_type",
        "get_typed_value": "value, data_type, can_be_str=",
        "is_instance_of": "value, data_type=, can_be_str=",
        "is_instance_of_valid_type": "value, can_be_str=",
        "is_normalized_substitution": "value",
        "is_substitution": "x",
        "is_typing_list": "data_type",
        "is_valid_scalar_type": "data_type",
        "normalize_typed_substitution": "value, data_type",
        "perform_typed_substitution": "context, value, data_type",
    },
    "launch.frontend": {
        "InvalidFrontendLaunchFileError": "extension=, *, likely_errors=",
        "expose_action": "name",
        "expose_substitution": "name",
    },
    "launch.logging": {
        "LaunchConfig": "",
        "get_logger": "name=",
        "get_output_loggers": "process_name, output_config, *, main_log_file_name=",
        "log_launch_config": "*, logger=",
        "reset": "",
    },
}

# Names that launch files import from the submodules; (module, name).
SUBMODULE_NAMES = [
    ("launch.action", "Action"),
    ("launch.actions.append_environment_variable", "AppendEnvironmentVariable"),
    ("launch.actions.declare_boolean_launch_argument", "DeclareBooleanLaunchArgument"),
    ("launch.actions.declare_launch_argument", "DeclareLaunchArgument"),
    ("launch.actions.execute_process", "ExecuteProcess"),
    ("launch.actions.include_launch_description", "IncludeLaunchDescription"),
    ("launch.actions.shutdown_action", "Shutdown"),
    ("launch.actions.timer_action", "TimerAction"),
    ("launch.condition", "Condition"),
    ("launch.conditions.if_condition", "IfCondition"),
    ("launch.event_handlers.on_process_exit", "OnProcessExit"),
    ("launch.event_handlers.on_shutdown", "OnShutdown"),
    ("launch.events.process.process_exited", "ProcessExited"),
    ("launch.frontend.expose", "expose_substitution"),
    ("launch.frontend.parse_substitution", "parse_substitution"),
    ("launch.launch_context", "LaunchContext"),
    ("launch.launch_description", "LaunchDescription"),
    ("launch.launch_description_entity", "LaunchDescriptionEntity"),
    ("launch.logging.handlers", "RotatingFileHandler"),
    ("launch.some_entities_type", "SomeEntitiesType"),
    ("launch.some_substitutions_type", "SomeSubstitutionsType"),
    ("launch.some_substitutions_type", "SomeSubstitutionsType_types_tuple"),
    ("launch.substitution", "Substitution"),
    ("launch.substitutions.launch_configuration", "LaunchConfiguration"),
    ("launch.substitutions.path_join_substitution", "PathJoinSubstitution"),
    ("launch.substitutions.substitution_failure", "SubstitutionFailure"),
    ("launch_ros.actions.node", "Node"),
    ("launch_ros.actions.node", "NodeActionExtension"),
    ("launch_ros.descriptions.composable_node", "ComposableNode"),
    ("launch_ros.parameters_type", "SomeParameters"),
    ("launch_ros.remap_rule_type", "SomeRemapRules"),
    ("launch_ros.ros_adapters", "get_ros_node"),
    ("launch_ros.substitutions.find_package", "FindPackageShare"),
    ("launch_ros.utilities.normalize_parameters", "normalize_parameter_dict"),
    ("launch_testing.actions", "ReadyToTest"),
    ("launch_xml.launch_description_sources", "XMLLaunchDescriptionSource"),
    ("launch_yaml.launch_description_sources", "YAMLLaunchDescriptionSource"),
]


@pytest.fixture(autouse=True)
def open_vocabulary() -> Iterator[None]:
    with vocabulary():
        yield


def spelled(thing: Any) -> str:
    """The signature as the table writes it."""
    parts: list[str] = []
    called = thing.__init__ if isinstance(thing, type) else thing
    if called is object.__init__:
        return ""
    parameters = list(inspect.signature(called).parameters.values())
    for parameter in parameters[1:] if isinstance(thing, type) else parameters:
        if parameter.kind is parameter.VAR_POSITIONAL:
            parts.append(f"*{parameter.name}")
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not any(p[:1] == "*" for p in parts):
            parts.append("*")
        prefix = "**" if parameter.kind is parameter.VAR_KEYWORD else ""
        default = "" if parameter.default is parameter.empty else "="
        parts.append(f"{prefix}{parameter.name}{default}")
    return ", ".join(parts)


@pytest.mark.parametrize(
    ("module", "name"), [(module, name) for module, names in SIGNATURES.items() for name in names]
)
def test_a_public_name_has_the_real_signature(module: str, name: str):
    thing = getattr(importlib.import_module(module), name)

    assert spelled(thing) == SIGNATURES[module][name]


@pytest.mark.parametrize(("module", "name"), SUBMODULE_NAMES)
def test_the_submodule_paths_that_people_import_are_there(module: str, name: str):
    assert hasattr(importlib.import_module(module), name)


@pytest.mark.parametrize("module", sorted(PUBLIC_MODULES))
def test_whatever_a_module_lists_can_be_had(module: str):
    listed = importlib.import_module(module)

    assert all(hasattr(listed, name) for name in listed.__all__)


def test_a_class_shows_the_path_that_ros_2_users_know():
    text_substitution = importlib.import_module("launch.substitutions").TextSubstitution

    assert repr(text_substitution) == (
        "<class 'launch.substitutions.text_substitution.TextSubstitution'>"
    )


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("launch.actions", "LogInfo"),
        ("launch.conditions", "IfCondition"),
        ("launch.launch_description_sources", "PythonLaunchDescriptionSource"),
        ("launch.substitutions", "EnvironmentVariable"),
    ],
)
def test_a_wrong_call_is_reported_with_the_name_of_the_class(module: str, name: str):
    with pytest.raises(TypeError, match=rf"^{name}.__init__\(\) missing 1 required"):
        getattr(importlib.import_module(module), name)()


@pytest.mark.parametrize(
    ("module", "name"), [(module, name) for module, names in SIGNATURES.items() for name in names]
)
def test_no_constructor_has_the_name_of_a_class_that_ros_2_does_not_have(module: str, name: str):
    thing = getattr(importlib.import_module(module), name)
    if isinstance(thing, type):
        owner = next(one for one in thing.__mro__ if "__init__" in vars(one))
        assert not owner.__module__.startswith("launcher.")


def test_submodules_are_there_after_a_mere_import_of_the_package():
    launch = importlib.import_module("launch")

    assert launch.actions.LogInfo is importlib.import_module("launch.actions").LogInfo
    assert launch.utilities.type_utils.is_substitution([]) is False


def test_an_unknown_name_is_an_import_error_that_says_what_there_is():
    with pytest.raises(ImportError, match=r"did you mean LogInfo.*provided: .*TimerAction"):
        exec("from launch.actions import LogInf")


def test_hasattr_is_false_for_unknown_names():
    assert not hasattr(importlib.import_module("launch.actions"), "NothingOfTheSort")


def test_the_packages_list_their_submodules():
    listed = {
        module.name
        for name in (*TOP_NAMES, *TOOL_NAMES)
        for module in pkgutil.walk_packages(importlib.import_module(name).__path__, f"{name}.")
    }

    assert {*listed, *TOP_NAMES, *TOOL_NAMES} == PUBLIC_MODULES


def test_a_function_is_not_hidden_by_the_submodule_of_its_name():
    importlib.import_module("launch_ros.utilities.normalize_parameters")

    assert callable(importlib.import_module("launch_ros.utilities").normalize_parameters)


class _Base:
    name: str = read_only("What it is called.")
    alias: str = read_only(of="__name")

    def __init__(self, name: str) -> None:
        self.__name = name


class _Derived(_Base):
    name: str = read_only()

    def __init__(self, name: str) -> None:
        super().__init__("base")
        self.__name = name


def test_a_read_only_attribute_gives_that_of_the_class_that_declares_it():
    derived = _Derived("derived")

    assert (derived.name, derived.alias) == ("derived", "base")
    assert _Base.name.__doc__ == "What it is called."


def test_a_read_only_attribute_cannot_be_set():
    base = _Base("base")

    with pytest.raises(AttributeError, match="name"):
        base.name = "other"
