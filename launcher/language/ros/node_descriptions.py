"""Node and NodeTrait descriptions: ROS nodes inside of a RosExecutable."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.base.model.parameter_text import rule
from launcher.language.executable import Executable
from launcher.language.naming import public, read_only
from launcher.language.ros.generated_files import write_parameters
from launcher.language.ros.node_and_topic_names import (
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
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine


@public("launch_ros.descriptions.node_trait")
class NodeTrait:
    """Something special about a node; subclasses override `prepare`."""

    def prepare(self, node: Node, context: LaunchContext, action: Any) -> None:
        """Called when the node is prepared."""


@public("launch_ros.descriptions.node")
class Node:
    """A ROS node of an executable: it adds words to the executable's command line."""

    node_name: object = read_only("The name as it was given.")
    node_namespace: object = read_only("The namespace as it was given.")
    final_node_name: str | None = read_only("The full name, once prepared.")

    def __init__(
        self,
        *,
        node_name: object = None,
        node_namespace: object = None,
        original_node_name: object = None,
        parameters: object = None,
        remappings: Any = None,
        arguments: Iterable[Any] | None = None,
        traits: Iterable[NodeTrait] | None = None,
        **kwargs: object,
    ) -> None:
        self.__node_name = node_name
        self.__node_namespace = node_namespace
        self.__original_node_name = original_node_name
        self.__parameters = () if parameters is None else normalize_parameters(parameters)
        self.__remappings = [] if remappings is None else list(normalize_remap_rules(remappings))
        self.__arguments = arguments
        self.__traits = traits
        self.__final_node_name: str | None = None

    def prepare(self, context: LaunchContext, executable: Any, action: Any) -> None:
        """Add the node's words to the executable's command line."""
        name = None if self.__node_name is None else perform(context, self.__node_name)
        namespace = self._namespace(context)
        words = ["--ros-args"]
        if name is not None:
            validate_node_name(name)
            words += ["-r", f"{self._prefix(context)}__node:={name}"]
        if namespace is not None:
            validate_namespace(namespace)
            words += ["-r", f"{self._prefix(context)}__ns:={namespace}"]
        self.__final_node_name = prefix_namespace(namespace, name)
        words += self._parameter_words(context, getattr(action, "_origin", None))
        for src, dst in self.__remappings:
            rule = f"{perform_substitutions(context, src)}:={perform_substitutions(context, dst)}"
            words += ["-r", rule]
        for word in [*words, *(self.__arguments or ())]:
            executable.cmd.append(normalize_to_list_of_substitutions(word))
        for trait in self.__traits or ():
            trait.prepare(self, context, action)

    def _prefix(self, context: LaunchContext) -> str:
        if self.__original_node_name is None:
            return ""
        return f"{perform(context, self.__original_node_name)}:"

    def _namespace(self, context: LaunchContext) -> str | None:
        given = self.__node_namespace
        return resolve_namespace(context, None if given is None else perform(context, given))

    def _parameter_words(self, context: LaunchContext, origin: FileLine | None) -> list[str]:
        words: list[str] = []
        for parameter in evaluate_parameters(context, self.__parameters):
            if isinstance(parameter, Parameter):
                name, value = parameter.evaluate(context)
                is_text = isinstance(value, str)
                words += ["-p", rule(name, value) if is_text else f"{name}:={value}"]
            elif isinstance(parameter, dict):
                node = self.__final_node_name or "/**"
                words += ["--params-file", write_parameters(context, node, parameter, origin)]
            else:
                words += ["--params-file", str(parameter)]
        return words


@public("launch_ros.descriptions.ros_executable")
class RosExecutable(Executable):
    """An executable with ROS nodes, for `launch.actions.ExecuteLocal`."""

    package: Any = read_only()
    executable: Any = read_only()
    nodes: object = read_only()

    def __init__(
        self,
        *,
        executable: object = None,
        package: Any = None,
        nodes: Iterable[Any] | None = None,
        **kwargs: Any,
    ) -> None:
        program = executable
        if package is not None:
            program = ExecutableInPackage(package=package, executable=executable)
        self.__package = package
        self.__executable = executable
        self.__nodes = nodes
        super().__init__(cmd=[program], **kwargs)

    def prepare(self, context: LaunchContext, action: Any) -> None:
        """Prepare the nodes, then the command."""
        for node in self.__nodes or ():
            node.prepare(context, self, action)
        super().prepare(context, action)
