"""The modules that launch files import, the names in them, and where they are defined here."""

# Public module -> module of the launcher -> names; `New=Old` is called `Old` there.
MODULES = {
    "launch": {
        "launcher.language.action": "Action",
        "launcher.language.conditions": "Condition",
        "launcher.language.context": "LaunchContext",
        "launcher.language.description": "LaunchDescription",
        "launcher.language.entity": "LaunchDescriptionEntity",
        "launcher.language.events.base": "Event EventHandler",
        "launcher.language.introspection": "LaunchIntrospector",
        "launcher.language.service": "LaunchService",
        "launcher.language.some_types": (
            "SomeEntitiesType SomeEntitiesType_types_tuple SomeSubstitutionsType"
        ),
        "launcher.language.sources": "InvalidLaunchFileError LaunchDescriptionSource",
        "launcher.language.substitution": "SomeSubstitutionsType_types_tuple Substitution",
    },
    "launch.actions": {
        "launcher.language.actions.arguments": (
            "DeclareBooleanLaunchArgument DeclareLaunchArgument"
        ),
        "launcher.language.actions.configuration": (
            "AppendEnvironmentVariable PopEnvironment PopLaunchConfigurations PushEnvironment "
            "PushLaunchConfigurations ReplaceEnvironmentVariables ResetEnvironment "
            "ResetLaunchConfigurations SetEnvironmentVariable SetLaunchConfiguration "
            "UnsetEnvironmentVariable UnsetLaunchConfiguration"
        ),
        "launcher.language.actions.coroutine": "OpaqueCoroutine",
        "launcher.language.actions.event_actions": (
            "EmitEvent Log LogDebug LogError LogInfo LogWarning OpaqueFunction "
            "RegisterEventHandler Shutdown UnregisterEventHandler"
        ),
        "launcher.language.actions.group": "GroupAction",
        "launcher.language.actions.include": "IncludeLaunchDescription",
        "launcher.language.actions.loops": "ForEach ForLoop",
        "launcher.language.actions.process": "ExecuteLocal ExecuteProcess",
        "launcher.language.actions.timer": "TimerAction",
    },
    "launch.conditions": {
        "launcher.language.conditions": (
            "IfCondition InvalidConditionExpressionError LaunchConfigurationEquals "
            "LaunchConfigurationNotEquals UnlessCondition evaluate_condition_expression"
        ),
    },
    "launch.descriptions": {"launcher.language.executable": "Executable"},
    "launch.event_handler": {"launcher.language.events.base": "BaseEventHandler EventHandler"},
    "launch.event_handlers": {
        "launcher.language.actions.process": "OnProcessExit OnProcessIO OnProcessStart",
        "launcher.language.events.handlers": (
            "OnActionEventBase OnExecutionComplete OnIncludeLaunchDescription OnShutdown "
            "event_named"
        ),
    },
    "launch.events": {
        "launcher.language.events.launch": (
            "ExecutionComplete IncludeLaunchDescription Shutdown TimerEvent matches_action"
        ),
    },
    "launch.events.process": {
        "launcher.language.events.process": (
            "ProcessExited ProcessIO ProcessStarted ProcessStderr ProcessStdin ProcessStdout "
            "ProcessTargetedEvent RunningProcessEvent ShutdownProcess SignalProcess "
            "matches_executable matches_name matches_pid"
        ),
    },
    "launch.frontend": {
        "launcher.language.frontends.entity": "Entity",
        "launcher.language.frontends.grammar_substitutions": (
            "parse_if_substitutions parse_substitution"
        ),
        "launcher.language.frontends.parser": "InvalidFrontendLaunchFileError Parser",
        "launcher.language.frontend_registry": "expose_action expose_substitution",
    },
    "launch.frontend.expose": {
        "launcher.language.frontends.expose": "instantiate_action instantiate_substitution",
        "launcher.language.frontend_registry": (
            "action_parse_methods expose_action expose_substitution substitution_parse_methods"
        ),
    },
    "launch.frontend.parser": {
        "launcher.language.frontends.parser": (
            "InvalidFrontendLaunchFileError Parser importlib_metadata"
        ),
    },
    "launch.frontend.parse_substitution": {
        "launcher.language.frontends.grammar": "replace_escaped_characters=unescape",
        "launcher.language.frontends.grammar_substitutions": (
            "parse_if_substitutions parse_substitution"
        ),
    },
    "launch.frontend.type_utils": {
        "launcher.language.frontends.entity": (
            "check_is_list_entity=is_entity_list get_data_type_from_identifier"
        ),
    },
    "launch.launch_description_sources": {
        "launcher.language.sources": (
            "AnyLaunchDescriptionSource FrontendLaunchDescriptionSource "
            "InvalidFrontendLaunchFileError=InvalidLaunchFileError InvalidPythonLaunchFileError "
            "PythonLaunchDescriptionSource get_launch_description_from_any_launch_file "
            "get_launch_description_from_frontend_launch_file "
            "get_launch_description_from_python_launch_file load_python_launch_file_as_module"
        ),
    },
    "launch.logging": {
        "launcher.language.logging.config": (
            "LaunchConfig LaunchLogger get_logger get_output_loggers launch_config "
            "log_launch_config reset"
        ),
    },
    "launch.logging.handlers": {
        "launcher.language.logging.handlers": (
            "FileHandler Handler MemoryHandler NullHandler QueueHandler RotatingFileHandler "
            "SocketHandler StreamHandler SysLogHandler TimedRotatingFileHandler "
            "WatchedFileHandler"
        ),
    },
    "launch.some_actions_type": {
        "launcher.language.some_types": "SomeActionsType SomeActionsType_types_tuple",
    },
    "launch.substitutions": {
        "launcher.language.substitution": "SubstitutionFailure TextSubstitution",
        "launcher.language.substitutions.command": "Command",
        "launcher.language.substitutions.configuration": (
            "EnvironmentVariable LaunchConfiguration LocalSubstitution"
        ),
        "launcher.language.substitutions.files": (
            "FileContent FindExecutable LaunchLogDir PathJoinSubstitution "
            "PathSubstitution ThisLaunchFile ThisLaunchFileDir"
        ),
        "launcher.language.substitutions.logic": (
            "AllSubstitution AndSubstitution AnySubstitution EqualsSubstitution "
            "IfElseSubstitution NotEqualsSubstitution "
            "NotSubstitution OrSubstitution"
        ),
        "launcher.language.substitutions.anon_name": "AnonName",
        "launcher.language.substitutions.for_loop_var": "ForEachVar ForLoopIndex",
        "launcher.language.substitutions.python": "PythonExpression",
        "launcher.language.substitutions.text": "StringJoinSubstitution",
    },
    "launch.utilities": {
        "launcher.language.class_tools": "ensure_argument_type is_a is_a_subclass isclassinstance",
        "launcher.language.substitution": (
            "normalize_to_list_of_substitutions perform_substitutions"
        ),
        "launcher.language.signals": "AsyncSafeSignalManager",
        "launcher.language.utilities": (
            "create_future get_signal_name normalize_to_list_of_entities "
            "visit_all_entities_and_collect_futures"
        ),
    },
    "launch.utilities.type_utils": {
        "launcher.language.some_types": (
            "AllowedTypesTuple AllowedTypesType AllowedValueType ListTypesTuple ListTypesType "
            "ListValueType NormalizedScalarType NormalizedSequenceType NormalizedValueType "
            "ScalarTypesType ScalarValueType SequenceValueType SomeScalarType SomeSequenceType "
            "SomeValueType StrSomeScalarType StrSomeSequenceType StrSomeValueType"
        ),
        "launcher.language.type_utils": (
            "ScalarTypesTuple coerce_list coerce_to_type extract_type get_typed_value "
            "is_instance_of is_instance_of_valid_type is_normalized_substitution is_substitution "
            "is_typing_list is_valid_scalar_type normalize_typed_substitution "
            "perform_typed_substitution"
        ),
    },
    "launch.utilities.typing_file_path": {"launcher.language.some_types": "FilePath"},
    "launch_ros": {"launcher.language.ros.adapters": "get_default_launch_description"},
    "launch_ros.actions": {
        "launcher.language.actions.timer": "ROSTimer=RosTimer RosTimer",
        "launcher.language.ros.composition": "ComposableNodeContainer LoadComposableNodes",
        "launcher.language.ros.lifecycle": "LifecycleNode LifecycleTransition",
        "launcher.language.ros.node": "Node",
        "launcher.language.ros.scope": (
            "PushROSNamespace PushRosNamespace=PushROSNamespace SetParameter "
            "SetParametersFromFile SetROSLogDir SetRemap SetUseSimTime"
        ),
    },
    "launch_ros.actions.load_composable_nodes": {
        "launcher.language.ros.composition": "LoadComposableNodes get_composable_node_load_request",
    },
    "launch_ros.actions.node": {"launcher.language.ros.node": "Node NodeActionExtension"},
    "launch_ros.descriptions": {
        "launcher.language.ros.composable_lifecycle": "ComposableLifecycleNode",
        "launcher.language.ros.composition": "ComposableNode",
        "launcher.language.ros.node_descriptions": "Node NodeTrait RosExecutable",
        "launcher.language.ros.parameter_descriptions": "Parameter ParameterFile ParameterValue",
    },
    "launch_ros.event_handlers": {"launcher.language.ros.lifecycle": "OnStateTransition"},
    "launch_ros.events": {"launcher.language.ros.lifecycle": "matches_node_name"},
    "launch_ros.events.lifecycle": {
        "launcher.language.ros.lifecycle": "ChangeState StateTransition matches_node_name",
    },
    "launch_ros.parameter_descriptions": {
        "launcher.language.ros.parameter_descriptions": "Parameter ParameterFile ParameterValue",
    },
    "launch_ros.parameters_type": {
        "launcher.language.ros.some_types": (
            "EvaluatedParameterValue EvaluatedParameters MultiValueType ParameterFile "
            "ParameterName ParameterValue Parameters ParametersDict SingleValueType "
            "SomeParameterFile SomeParameterName SomeParameterValue SomeParameters "
            "SomeParametersDict"
        ),
    },
    "launch_ros.remap_rule_type": {
        "launcher.language.ros.some_types": "RemapRule RemapRules SomeRemapRule SomeRemapRules",
    },
    "launch_ros.ros_adapters": {
        "launcher.language.ros.adapters": "ROSAdapter get_ros_adapter get_ros_node",
    },
    "launch_ros.substitutions": {
        "launcher.language.ros.packages": (
            "ExecutableInPackage FindPackage FindPackagePrefix FindPackageShare"
        ),
        "launcher.language.ros.scope": "Parameter",
    },
    "launch_ros.utilities": {
        "launcher.language.ros.component_parameters": "to_parameters_list",
        "launcher.language.ros.lifecycle": "LifecycleEventManager",
        "launcher.language.ros.node_and_topic_names": (
            "add_node_name get_node_name_count is_namespace_absolute is_root_namespace "
            "make_namespace_absolute normalize_remap_rule normalize_remap_rules prefix_namespace"
        ),
        "launcher.language.ros.parameter_values": (
            "evaluate_parameter_dict evaluate_parameters "
            "evaluate_parameters_dict=evaluate_parameter_dict normalize_parameter_dict "
            "normalize_parameters normalize_parameters_dict=normalize_parameter_dict"
        ),
    },
    "launch_ros.utilities.plugin_support": {
        "launcher.language.ros.adapters": "PluginException satisfies_version",
    },
    "launch_xml": {"launcher.language.frontends.xml": "Entity=XmlEntity Parser=XmlParser"},
    "launch_xml.launch_description_sources": {
        "launcher.language.sources": "XMLLaunchDescriptionSource",
    },
    "launch_yaml": {"launcher.language.frontends.yaml": "Entity=YamlEntity Parser=YamlParser"},
    "launch_yaml.launch_description_sources": {
        "launcher.language.sources": "YAMLLaunchDescriptionSource",
    },
}

# Public package -> submodules that have one class, named after it: `emit_event` has EmitEvent.
CLASS_SUBMODULES = {
    "launch": (
        "action condition event invalid_launch_file_error launch_context launch_description "
        "launch_description_entity launch_description_source launch_introspector launch_service "
        "substitution"
    ),
    "launch.actions": (
        "append_environment_variable declare_boolean_launch_argument declare_launch_argument "
        "emit_event execute_local execute_process group_action include_launch_description "
        "log_info opaque_coroutine opaque_function pop_environment pop_launch_configurations "
        "push_environment push_launch_configurations register_event_handler "
        "replace_environment_variables reset_environment reset_launch_configurations "
        "set_environment_variable set_launch_configuration timer_action unregister_event_handler "
        "unset_environment_variable unset_launch_configuration"
    ),
    "launch.conditions": (
        "if_condition invalid_condition_expression_error launch_configuration_equals "
        "launch_configuration_not_equals unless_condition"
    ),
    "launch.descriptions": "executable",
    "launch.event_handlers": (
        "on_action_event_base on_execution_complete on_include_launch_description on_process_exit "
        "on_process_start on_shutdown"
    ),
    "launch.events": "execution_complete include_launch_description shutdown timer_event",
    "launch.events.process": (
        "process_exited process_started process_stderr process_stdin process_stdout "
        "process_targeted_event running_process_event shutdown_process signal_process"
    ),
    "launch.frontend": "entity",
    "launch.launch_description_sources": (
        "any_launch_description_source frontend_launch_description_source "
        "python_launch_description_source"
    ),
    "launch.substitutions": (
        "anon_name command environment_variable equals_substitution file_content find_executable "
        "if_else_substitution launch_configuration "
        "launch_log_dir local_substitution not_equals_substitution "
        "path_join_substitution path_substitution python_expression string_join_substitution "
        "substitution_failure text_substitution this_launch_file "
        "this_launch_file_dir"
    ),
    "launch_ros.actions": (
        "composable_node_container lifecycle_node lifecycle_transition set_parameter "
        "set_parameters_from_file set_remap set_use_sim_time"
    ),
    "launch_ros.descriptions": (
        "composable_lifecycle_node composable_node node node_trait ros_executable"
    ),
    "launch_ros.event_handlers": "on_state_transition",
    "launch_ros.events.lifecycle": "change_state state_transition",
    "launch_ros.substitutions": "executable_in_package parameter",
    "launch_xml": "entity parser",
    "launch_yaml": "entity parser",
}

# Public package -> other submodule -> names, which are those of the package.
SUBMODULES = {
    "launch": {
        "some_entities_type": "SomeEntitiesType SomeEntitiesType_types_tuple",
        "some_substitutions_type": "SomeSubstitutionsType SomeSubstitutionsType_types_tuple",
    },
    "launch.actions": {
        "for_loop": "ForEach ForLoop",
        "log": "Log LogDebug LogError LogInfo LogWarning",
        "shutdown_action": "Shutdown",
    },
    "launch.conditions": {"evaluate_condition_expression_impl": "evaluate_condition_expression"},
    "launch.event_handlers": {
        "event_named": "event_named",
        "on_process_io": "OnProcessIO",
    },
    "launch.events": {"matchers": "matches_action"},
    "launch.events.process": {
        "process_io": "ProcessIO",
        "process_matchers": "matches_executable matches_name matches_pid",
    },
    "launch.launch_description_sources": {
        "any_launch_file_utilities": "get_launch_description_from_any_launch_file",
        "frontend_launch_file_utilities": "get_launch_description_from_frontend_launch_file",
        "python_launch_file_utilities": (
            "InvalidPythonLaunchFileError get_launch_description_from_python_launch_file "
            "load_python_launch_file_as_module"
        ),
    },
    "launch.substitutions": {
        "boolean_substitution": (
            "AllSubstitution AndSubstitution AnySubstitution NotSubstitution OrSubstitution"
        ),
        "for_loop_var": "ForEachVar ForLoopIndex",
    },
    "launch.utilities": {
        "class_tools_impl": "is_a is_a_subclass isclassinstance",
        "create_future_impl": "create_future",
        "signal_management": "AsyncSafeSignalManager",
        "ensure_argument_type_impl": "ensure_argument_type",
        "normalize_to_list_of_entities_impl": "normalize_to_list_of_entities",
        "normalize_to_list_of_substitutions_impl": "normalize_to_list_of_substitutions",
        "perform_substitutions_impl": "perform_substitutions",
        "visit_all_entities_and_collect_futures_impl": "visit_all_entities_and_collect_futures",
    },
    "launch_ros.actions": {
        "push_ros_namespace": "PushROSNamespace PushRosNamespace",
        "ros_timer": "ROSTimer RosTimer",
        "set_ros_log_dir": "SetROSLogDir",
    },
    "launch_ros": {"default_launch_description": "get_default_launch_description"},
    "launch_ros.events.lifecycle": {"lifecycle_node_matchers": "matches_node_name"},
    "launch_ros.events": {"matchers": "matches_node_name"},
    "launch_ros.substitutions": {
        "find_package": "FindPackage FindPackagePrefix FindPackageShare",
    },
    "launch_ros.utilities": {
        "evaluate_parameters": "evaluate_parameter_dict evaluate_parameters",
        "namespace_utils": (
            "is_namespace_absolute is_root_namespace make_namespace_absolute prefix_namespace"
        ),
        "lifecycle_event_manager": "LifecycleEventManager",
        "normalize_parameters": "normalize_parameter_dict normalize_parameters",
        "normalize_remap_rule": "normalize_remap_rule normalize_remap_rules",
        "to_parameters_list": "to_parameters_list",
        "track_node_names": "add_node_name get_node_name_count",
    },
    "launch_xml.launch_description_sources": {
        "xml_launch_description_source": "XMLLaunchDescriptionSource",
    },
    "launch_yaml.launch_description_sources": {
        "yaml_launch_description_source": "YAMLLaunchDescriptionSource",
    },
}
for _package, _names in CLASS_SUBMODULES.items():
    SUBMODULES.setdefault(_package, {}).update(
        (name, name.title().replace("_", "")) for name in _names.split()
    )
