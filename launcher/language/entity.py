"""Base class of everything that can be in a launch description."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.diagnostics.origin import FileLine, caller_origin
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.launch_description_entity")
class LaunchDescriptionEntity:
    """Base of descriptions and actions; visiting one may yield further entities."""

    _origin: FileLine | None

    # Role in the search for launch arguments: "declares" an argument, "includes" a file, or
    # "resets" the configurations, which ends the search.
    _to_arguments = ""

    def __new__(cls, *args: object, **kwargs: object) -> Any:
        """Remember the place of creation, also for subclasses that never call `__init__`."""
        entity = super().__new__(cls)
        entity._origin = caller_origin()
        return entity

    def __init__(self) -> None:
        """Subclasses need not call it: `__new__` sets what the launcher needs."""

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Execute; the entities returned are visited next, in order."""
        cls = type(self)
        if cls is not LaunchDescriptionEntity and cls.visit is LaunchDescriptionEntity.visit:
            # Imported only for a warning.
            from launcher.language.diagnostics.base_classes import warn_of_idle_entity

            warn_of_idle_entity(self, context, "visit")
        return None

    def describe(self) -> str:
        """A line about the entity; NotImplementedError if a subclass has no such method."""
        raise NotImplementedError(f"{type(self).__name__} has no method describe()")

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Entities that a visit would yield, as far as that is known without a context."""
        return []

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """(condition, entities) for what a visit may yield later."""
        return []

    def get_asyncio_future(self) -> Any:
        """A future that is done when the entity has finished; None if the visit finishes it."""
        return None
