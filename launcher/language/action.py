"""Base class of actions: entities that do something, optionally under a condition."""

from __future__ import annotations

from launcher.language import frontend_registry
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.events.launch import ExecutionComplete
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.conditions import Condition
    from launcher.language.context import LaunchContext


def holds(condition: Condition, context: LaunchContext) -> bool:
    """Whether a condition, also of a launch file's own class, is true in this context."""
    truth: object = condition.evaluate(context)
    if truth is None or isinstance(truth, (str, list, tuple, dict)):
        # Imported only for a possible mistake.
        from launcher.language.diagnostics.wrong_returns import warn_of_no_truth

        warn_of_no_truth(condition, truth, context)
    return bool(truth)


@public("launch.action")
class Action(LaunchDescriptionEntity):
    """Base of all actions; subclasses override `execute`."""

    _was_executed = False  # in this run
    condition: Condition | None = read_only()

    def __init__(self, *, condition: Condition | None = None) -> None:
        self.__condition = condition

    @classmethod
    def parse(cls, entity: object, parser: object) -> tuple[type, dict[str, Any]]:
        """(class, keyword arguments) for an XML or YAML entity; subclasses call super()."""
        parsed: tuple[type, dict[str, Any]]
        parsed = frontend_registry.parse_with("Action", cls, entity, parser)
        return parsed

    def describe(self) -> str:
        return self.__repr__()

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Execute if the condition allows it, then emit ExecutionComplete."""
        if self.__condition is not None and not holds(self.__condition, context):
            context._host.skipped(self)
            return None
        self._was_executed = True
        try:
            below: list[LaunchDescriptionEntity] | None = self.execute(context)
            return below
        finally:
            self._emit_completion(context)

    def _emit_completion(self, context: LaunchContext) -> None:
        event = ExecutionComplete(action=self)
        if not context.would_handle_event(event):
            return
        future = self.get_asyncio_future()
        if future is None:
            context.emit_event_sync(event)
        else:
            future.add_done_callback(lambda _: context.emit_event_sync(event))

    def execute(self, context: LaunchContext) -> Any:
        """Called by `visit`; the entities returned are visited next."""
        if type(self) is not Action and type(self).execute is Action.execute:
            # Imported only for a warning.
            from launcher.language.diagnostics.base_classes import warn_of_idle_entity

            warn_of_idle_entity(self, context, "execute")
        return None

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Entities that the action is known to yield; overridden by subclasses."""
        return []

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """The sub-entities, unless a condition decides about them."""
        return self.get_sub_entities() if self.condition is None else []

    def describe_conditional_sub_entities(self) -> Any:
        """The sub-entities behind the condition, if there is one."""
        if self.condition is None:
            return []
        return [(f"Conditionally included by {self.describe()}", self.get_sub_entities())]
