"""ComposableLifecycleNode: a composable node that has a lifecycle."""

from __future__ import annotations

from launcher.language.class_tools import ensure_argument_type
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.ros.composition import ComposableNode
from launcher.language.ros.lifecycle import LifecycleEventManager, activation
from launcher.language.substitution import SomeSubstitutionsType_types_tuple
from launcher.language.type_utils import (
    normalize_typed_substitution,
    perform_typed_substitution,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.action import Action
    from launcher.language.context import LaunchContext

_LOGGER = "launch_ros.actions.load_composable_nodes"


@public("launch_ros.descriptions.composable_lifecycle_node")
@parsed
class ComposableLifecycleNode(ComposableNode):
    """A lifecycle node that is a plug-in; with `autostart`, it is configured and activated.

    Its transitions are events, and ChangeState events reach it, also without `autostart`, which
    ROS 2 requires for that. There matchers do not find it, since they are given its plain name.
    """

    node_autostart: Any = read_only("True, false, or substitutions.", of="__autostart")

    def __init__(self, *, autostart: object = False, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        allowed = [*SomeSubstitutionsType_types_tuple, bool]
        ensure_argument_type(autostart, allowed, "autostart", "ComposableLifecycleNode")
        self.__autostart = normalize_typed_substitution(autostart, bool)
        self.__full_name = ""
        self.__manager: LifecycleEventManager | None = None

    @property
    def is_lifecycle_node(self) -> bool:
        return True

    @property
    def node_name(self) -> Any:
        """Namespace and name, once they are known; before, the name as substitutions."""
        return self.__full_name or self._given_name

    @property
    def _given_name(self) -> Any:
        return super().node_name

    def _begin_loading(self, context: LaunchContext, full_name: str) -> list[Action]:
        """Watch the node, and hold requests back until it is there."""
        is_started = perform_typed_substitution(context, self.node_autostart, bool)
        if full_name:
            self._watch(context, full_name)._hold()
        elif is_started:
            raise RuntimeError("a ComposableLifecycleNode with autostart needs a name")
        if not is_started:
            return []
        text = f"Autostart enabled for requested lifecycle node {full_name}"
        context._host.log(_LOGGER, "INFO", text)
        return [activation(full_name, self)]

    def _end_loading(self, context: LaunchContext, full_name: str, *, is_loaded: bool) -> None:
        if full_name:
            self._watch(context, full_name)._release(is_loaded=is_loaded)

    def _watch(self, context: LaunchContext, full_name: str) -> LifecycleEventManager:
        if self.__manager is None:
            self.__full_name = full_name
            self.__manager = LifecycleEventManager(self)
            self.__manager.setup_lifecycle_manager(context)
        return self.__manager
