"""Node: a process that is a ROS node, with its names, parameters and remappings."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from launcher.base.model.record import replace
from launcher.base.model.ros_arguments import PARAMETER, PARAMETER_FILE, ros_options
from launcher.base.model.spec import ParameterSource, RosIdentity
from launcher.language import frontend_registry, launch_session
from launcher.language.actions.process import ExecuteProcess
from launcher.language.class_tools import ensure_argument_type
from launcher.language.diagnostics import ros2_quirks
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.ros.generated_files import write_parameters
from launcher.language.ros.node_and_topic_names import (
    add_node_name,
    evaluate_remap_rules,
    make_namespace_absolute,
    normalize_remap_rules,
    prefix_namespace,
    resolve_namespace,
    validate_namespace,
    validate_node_name,
)
from launcher.language.ros.packages import ExecutableInPackage
from launcher.language.ros.parameter_descriptions import Parameter
from launcher.language.ros.parameter_values import evaluate_parameters, normalize_parameters
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform,
)
from launcher.language.substitutions.configuration import LocalSubstitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


_LOGGER = "launch_ros.actions.node"
UNSPECIFIED_NODE_NAME = "<node_name_unspecified>"
UNSPECIFIED_NODE_NAMESPACE = "<node_namespace_unspecified>"


class NodeActionExtension:
    """Base of plug-ins that add words to the command line of nodes."""

    NAME: str | None = None
    EXTENSION_POINT_VERSION = "0.1"

    def prepare_for_execute(
        self, context: LaunchContext, ros_specific_arguments: Any, node_action: Any
    ) -> tuple[list[Any], Any]:
        """(further words, the possibly changed arguments)."""
        return [], ros_specific_arguments


@public("launch_ros.actions.node")
@parsed
class Node(ExecuteProcess):
    """Starts a ROS node.

    A relative namespace goes below those that PushROSNamespace pushed. Each dictionary in
    `parameters` becomes a temporary parameter file; later ones win. Parameters and remappings of
    SetParameter and SetRemap come before the node's own.
    """

    UNSPECIFIED_NODE_NAME = UNSPECIFIED_NODE_NAME
    UNSPECIFIED_NODE_NAMESPACE = UNSPECIFIED_NODE_NAMESPACE
    node_package: Any = read_only("The package as it was given.", of="__package")
    node_executable: Any = read_only("The executable as it was given.")
    expanded_node_namespace: str = read_only("The namespace, with those pushed outside.")
    expanded_remapping_rules: list[tuple[str, str]] | None = read_only(
        "(from, to) pairs, those of SetRemap included; None without any.",
        of="__expanded_remappings",
    )

    def __init__(
        self,
        *,
        executable: Any,
        package: Any = None,
        name: Any = None,
        namespace: Any = None,
        exec_name: Any = None,
        parameters: Any = None,
        remappings: Any = None,
        ros_arguments: Iterable[Any] | None = None,
        arguments: Iterable[Any] | None = None,
        **kwargs: Any,
    ) -> None:
        program = executable
        if package is not None:
            program = ExecutableInPackage(package=package, executable=executable)
        cmd = [program, *([] if arguments is None else arguments)]
        if isinstance(arguments, str):
            # Imported only for a mistake.
            from launcher.language.diagnostics.text_uses import warn_of_letters

            warn_of_letters("arguments", arguments, self._origin)
        if ros_arguments is not None:
            ensure_argument_type(ros_arguments, list, "ros_arguments", "Node")
            cmd += ["--ros-args", *ros_arguments]
        cmd += ["--ros-args"]
        if name is not None:
            key = "ros_specific_arguments['name']"
            cmd += ["-r", LocalSubstitution(key, description="node name")]
        if parameters is not None:
            ensure_argument_type(parameters, list, "parameters", "Node")
            parameters = normalize_parameters(parameters)
        kwargs["name"] = exec_name
        super().__init__(cmd=cmd, **kwargs)
        launch_session.current().nodes_made += 1
        self.__program = program
        self.__package = package
        self.__node_executable = executable
        self.__node_name = name
        self.__node_namespace = namespace
        self.__parameters: tuple[Any, ...] = () if parameters is None else parameters
        self.__remappings = [] if remappings is None else list(normalize_remap_rules(remappings))
        self.__ros_arguments = ros_arguments
        self.__arguments = arguments
        self.__expanded_node_name = UNSPECIFIED_NODE_NAME
        self.__expanded_node_namespace = UNSPECIFIED_NODE_NAMESPACE
        self.__final_node_name: str | None = None
        # Subclasses read it, and so do tests of launch_ros.
        self.__expanded_parameter_arguments: list[tuple[str, bool]] = []
        self.__expanded_remappings: list[tuple[str, str]] | None = None
        self.__substitutions_performed = False

    @staticmethod
    def parse_nested_parameters(params: Any, parser: object) -> Any:
        """The `param` tags of an entity as the constructor's argument."""
        return frontend_registry.parse_with("Node.parameters", Node, params, parser)

    @property
    def node_name(self) -> str:
        """Namespace and name; RuntimeError before the visit."""
        if self.__final_node_name is None:
            raise RuntimeError("cannot access 'node_name' before executing action")
        return self.__final_node_name

    def is_node_name_fully_specified(self) -> bool:
        """Whether both name and namespace are known."""
        unknown = (UNSPECIFIED_NODE_NAME, UNSPECIFIED_NODE_NAMESPACE)
        return all(text not in self.node_name for text in unknown)

    # ---- the visit

    def _perform_substitutions(self, context: LaunchContext) -> None:
        if self.__substitutions_performed:
            return  # called by a subclass before
        self.__substitutions_performed = True
        try:
            self._expand_names(context)
        except Exception:
            context._host.log(
                _LOGGER,
                "ERROR",
                "Error while expanding or validating node name or namespace for "
                f"'package={self.__package}, executable={self.__node_executable}, "
                f"name={self.__node_name}, namespace={self.__node_namespace}':",
            )
            raise
        self.__final_node_name = prefix_namespace(
            self.__expanded_node_namespace, self.__expanded_node_name
        )
        self._add_global_parameters(context)
        self._add_own_parameters(context)
        self._add_remappings(context)

    def _expand_names(self, context: LaunchContext) -> None:
        if self.__node_name is not None:
            self.__expanded_node_name = perform(context, self.__node_name)
            validate_node_name(self.__expanded_node_name)
        given = None
        if self.__node_namespace is not None:
            given = perform(context, self.__node_namespace)
        namespace = resolve_namespace(context, given)
        if namespace is not None:
            self.__expanded_node_namespace = namespace
            self._add_words("-r", LocalSubstitution("ros_specific_arguments['ns']"))
            validate_namespace(namespace)

    def _add_words(self, *words: str | Substitution) -> None:
        self.cmd.extend([normalize_to_list_of_substitutions(word) for word in words])

    def _add_global_parameters(self, context: LaunchContext) -> None:
        for parameter in context.launch_configurations.get("global_params", None) or ():
            if isinstance(parameter, tuple):
                rule = f"{parameter[0]}:={parameter[1]}"
                self._add_words("-p", rule)
                self.__expanded_parameter_arguments.append((rule, False))
            else:
                path = os.path.abspath(parameter)
                if not os.path.isfile(path):
                    raise AssertionError(f"parameter file {path} does not exist")
                self._add_words("--params-file", path)
                self.__expanded_parameter_arguments.append((path, True))

    def _add_own_parameters(self, context: LaunchContext) -> None:
        for parameter in evaluate_parameters(context, self.__parameters):
            is_file = not isinstance(parameter, Parameter)
            argument = self._parameter_argument(context, parameter)
            if is_file and not os.path.isfile(argument):
                ros2_quirks.parameter_file_is_missing(context, argument, self._origin)
                continue
            self.__expanded_parameter_arguments.append((argument, is_file))
            self._add_words("--params-file" if is_file else "-p", argument)

    def _parameter_argument(self, context: LaunchContext, parameter: Any) -> str:
        if isinstance(parameter, dict):
            node = self.node_name if self.is_node_name_fully_specified() else "/**"
            return write_parameters(context, node, parameter, self._origin)
        if isinstance(parameter, Path):
            return str(parameter)
        return self._get_parameter_rule(parameter, context)

    @staticmethod
    def _get_parameter_rule(parameter: Parameter, context: LaunchContext) -> str:
        # Imported only for nodes with parameters, like yaml.
        from launcher.base.model.parameter_text import rule

        return rule(*parameter.evaluate(context))

    def _add_remappings(self, context: LaunchContext) -> None:
        rules = evaluate_remap_rules(context, self.__remappings)
        if rules:
            self.__expanded_remappings = rules
        for src, dst in rules:
            self._add_words("-r", f"{src}:={dst}")

    def execute(self, context: LaunchContext) -> Any:
        """Work out the command line, then start the process."""
        self._perform_substitutions(context)
        arguments = {"ns": f"__ns:={self.__expanded_node_namespace}"}
        if self.__node_name is not None:
            arguments["name"] = f"__node:={self.__expanded_node_name}"
        context.extend_locals({"ros_specific_arguments": arguments})
        result = super().execute(context)
        if self.is_node_name_fully_specified():
            add_node_name(context, self.node_name)
        return result

    def _ros_identity(self) -> RosIdentity:
        namespace: str | None = self.__expanded_node_namespace
        found = None if self.__package is None else self.__program._found
        # Also what stands in `arguments` and `ros_arguments`.
        given = ros_arguments(self.process_description.final_cmd or ())
        unnamed = self.__node_name is None
        if namespace == UNSPECIFIED_NODE_NAMESPACE:
            namespace = make_namespace_absolute(given.namespace)
        return replace(
            given,
            package=found[0] if found else None,
            executable=found[1] if found else self._program_word(),
            node_name=given.node_name if unnamed else self.__expanded_node_name,
            namespace=namespace,
        )

    def _program_word(self) -> str | None:
        words = self.process_description.final_cmd
        return None if not words else words[len(words) - len(self.process_description.cmd)]


# ---- the command line

_NAMES, _NAMESPACE = ("__node", "__name"), "__ns"


def ros_arguments(words: Iterable[str]) -> RosIdentity:
    """The arguments behind `--ros-args`, up to `--` or the end; what is malformed is left out.

    Name and namespace are those of rules that apply to every node of the process.
    """
    parameters: list[ParameterSource] = []
    remappings: list[tuple[str, str]] = []
    names: dict[str, str] = {}
    for option, value in ros_options(words):
        if option is PARAMETER_FILE:
            parameters.append(ParameterSource(file=value))
            continue
        left, separator, right = value.partition(":=")
        if not separator or not left:
            continue
        if option is PARAMETER:
            parameters.append(ParameterSource(rule=value))
        elif left in (*_NAMES, _NAMESPACE):
            names.setdefault(left, right)  # rcl takes the first rule that fits
        elif left.rpartition(":")[2] not in (*_NAMES, _NAMESPACE):  # of one node among several
            remappings.append((left, right))
    return RosIdentity(
        parameters=tuple(parameters),
        remappings=tuple(remappings),
        node_name=next((names[key] for key in _NAMES if key in names), None),
        namespace=names.get(_NAMESPACE),
    )
