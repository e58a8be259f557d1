"""Composable nodes: description, container, and loading into a container."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from launcher.base.model.events import ComponentLoaded, LoadRequest
from launcher.language.action import Action, holds
from launcher.language.class_tools import ensure_argument_type
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.ros.component_parameters import full_name, parameter_pairs
from launcher.language.ros.node import Node
from launcher.language.ros.node_and_topic_names import (
    add_node_name,
    evaluate_remap_rules,
    normalize_remap_rules,
    resolve_namespace,
)
from launcher.language.ros.parameter_descriptions import ParameterFile
from launcher.language.ros.parameter_values import (
    evaluate_parameters,
    normalize_parameter_dict,
    normalize_parameters,
)
from launcher.language.substitution import (
    SomeSubstitutionsType_types_tuple,
    Substitution,
    normalize_to_list_of_substitutions,
    optional_substitutions,
    perform,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.conditions import Condition
    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine

    _Load = tuple["ComposableNode", LoadRequest]

_LOGGER = "launch_ros.actions.load_composable_nodes"


@public("launch_ros.descriptions.composable_node")
@parsed
class ComposableNode:
    """A node that is a plug-in, to be loaded into a container."""

    package: list[Substitution] = read_only()
    node_plugin: list[Substitution] = read_only()
    node_namespace: list[Substitution] | None = read_only()
    parameters: Any = read_only()
    remappings: Any = read_only()
    extra_arguments: Any = read_only("Arguments for the container, normalised like parameters.")

    def __init__(
        self,
        *,
        package: Any,
        plugin: object,
        name: object = None,
        namespace: object = None,
        parameters: object = None,
        remappings: Any = None,
        extra_arguments: object = None,
        condition: Condition | None = None,
    ) -> None:
        self.__package = normalize_to_list_of_substitutions(package)
        self.__node_plugin = normalize_to_list_of_substitutions(plugin)
        self.__node_name = optional_substitutions(name)
        self.__node_namespace = optional_substitutions(namespace)
        self.__parameters = None if parameters is None else normalize_parameters(parameters)
        self.__remappings = list(normalize_remap_rules(remappings)) if remappings else None
        self.__extra_arguments = normalize_parameters(extra_arguments) if extra_arguments else None
        self.__condition = condition

    def condition(self) -> Condition | None:
        """The node is loaded only if this is true."""
        return self.__condition

    @property
    def node_name(self) -> Any:
        """The name as substitutions, or None."""
        return self.__node_name

    @property
    def _given_name(self) -> Any:
        """The same: `node_name` of a lifecycle node becomes the full name."""
        return self.node_name

    def _begin_loading(self, context: LaunchContext, full_name: str) -> list[Action]:
        """The node is going to be loaded, empty: its name is not known; what follows from that."""
        return []

    def _end_loading(self, context: LaunchContext, full_name: str, *, is_loaded: bool) -> None:
        """The container has answered."""


@public("launch_ros.actions.composable_node_container")
@parsed
class ComposableNodeContainer(Node):
    """Starts a container, and loads nodes into it."""

    def __init__(
        self,
        *,
        name: Any,
        namespace: Any,
        composable_node_descriptions: list[ComposableNode] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self.__composable_node_descriptions = composable_node_descriptions

    @property
    def _what_and_where(self) -> tuple[list[ComposableNode], Any]:
        """The nodes to load, and the container."""
        return self.__composable_node_descriptions or [], self

    def execute(self, context: LaunchContext) -> Any:
        """Start the container; yield an action that loads the nodes."""
        wanted = [
            description
            for description in self.__composable_node_descriptions or ()
            if _is_wanted(description, context)
        ]
        loads = []
        if wanted:
            loads = [
                LoadComposableNodes(composable_node_descriptions=wanted, target_container=self)
            ]
            loads[0]._origin = self._origin
        return [*(super().execute(context) or ()), *loads] or None


def _is_wanted(description: ComposableNode, context: LaunchContext) -> bool:
    condition = description.condition()
    return condition is None or holds(condition, context)


@public("launch_ros.actions.load_composable_nodes")
@parsed
class LoadComposableNodes(Action):
    """Requests a running container to load nodes, one after the other."""

    def __init__(
        self,
        *,
        composable_node_descriptions: list[ComposableNode],
        target_container: object,
        **kwargs: Any,
    ) -> None:
        ensure_argument_type(
            target_container,
            [*SomeSubstitutionsType_types_tuple, ComposableNodeContainer],
            "target_container",
            "LoadComposableNodes",
        )
        super().__init__(**kwargs)
        self.__composable_node_descriptions = composable_node_descriptions
        self.__target_container = target_container
        self.__container_name = ""

    @property
    def _what_and_where(self) -> tuple[list[ComposableNode], Any]:
        """The nodes to load, and the container or its name."""
        return self.__composable_node_descriptions, self.__target_container

    def execute(self, context: LaunchContext) -> list[Action] | None:
        """Build all requests in the current scope; send the first."""
        if isinstance(self.__target_container, ComposableNodeContainer):
            self.__container_name = self.__target_container.node_name
        else:
            self.__container_name = perform(context, self.__target_container)
        wanted: list[_Load] = []
        follows: list[Action] = []
        for description in self.__composable_node_descriptions:
            request = _load_request(description, context, self.__container_name, self._origin)
            if request is not None:
                wanted.append((description, request))
                follows += description._begin_loading(context, request.full_name)
        if wanted:
            context._host.later(lambda: self._send(context, wanted))
        return follows or None

    def _send(self, context: LaunchContext, loads: list[_Load]) -> None:
        (description, request), rest = loads[0], loads[1:]

        def answered(answer: ComponentLoaded) -> None:
            self._report(context, request, answer)
            name = answer.full_node_name or request.full_name
            description._end_loading(context, name, is_loaded=answer.error is None)
            if rest:
                context._host.later(lambda: self._send(context, rest))

        following = tuple(one for _, one in rest)
        context._host.load_component(request, answered, self._origin, following)

    def _report(
        self, context: LaunchContext, request: LoadRequest, answer: ComponentLoaded
    ) -> None:
        name = answer.full_node_name or request.name or ""
        container = self.__container_name
        if answer.error is not None:
            text = (
                f"Failed to load node '{name}' of type '{request.plugin}' "
                f"in container '{container}': {answer.error}"
            )
            context._host.log(_LOGGER, "ERROR", text)
            return
        add_node_name(context, name)
        text = f"Loaded node '{answer.full_node_name}' in container '{container}'"
        context._host.log(_LOGGER, "INFO", text)


def get_composable_node_load_request(
    composable_node_description: ComposableNode, context: LaunchContext
) -> Any:
    """The request as ROS 2 sends it; None if the description's condition is false."""
    from launcher.language.ros.load_requests import ros_request  # imports messages

    request = _load_request(composable_node_description, context, "", None)
    return None if request is None else ros_request(request)


def _load_request(
    composable_node_description: ComposableNode,
    context: LaunchContext,
    container: str,
    origin: FileLine | None,
) -> LoadRequest | None:
    """The request to the container; None if the description's condition is false."""
    description = composable_node_description
    if not _is_wanted(description, context):
        return None
    name = _performed(context, description._given_name) or ""
    namespace = resolve_namespace(context, _performed(context, description.node_namespace))

    def pairs(parameters: Iterable[Any]) -> tuple[tuple[str, object], ...]:
        evaluated = evaluate_parameters(context, parameters)
        for path in (str(one) for one in evaluated if isinstance(one, Path)):
            node = full_name(name, namespace) if name else None
            context._host.uses_parameter_file(path, node, origin)
        return tuple(parameter_pairs(context, name, namespace, evaluated))

    parameters = [*_global_parameters(context), *(description.parameters or ())]
    return LoadRequest(
        container=container,
        package=perform_substitutions(context, description.package),
        plugin=perform_substitutions(context, description.node_plugin),
        name=name,
        namespace=namespace or "",
        remappings=tuple(evaluate_remap_rules(context, description.remappings or ())),
        parameters=pairs(parameters) if parameters else (),
        extra_arguments=pairs(description.extra_arguments) if description.extra_arguments else (),
    )


def _performed(context: LaunchContext, subs: list[Substitution] | None) -> str | None:
    return None if subs is None else perform_substitutions(context, subs)


def _global_parameters(context: LaunchContext) -> list[Any]:
    return [
        normalize_parameter_dict({parameter[0]: parameter[1]})
        if isinstance(parameter, tuple)
        else ParameterFile(Path(parameter).resolve())
        for parameter in context.launch_configurations.get("global_params", None) or ()
    ]
