"""Base classes of events and event handlers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator

from launcher.language import launch_session
from launcher.language.diagnostics.origin import caller_origin
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.entity import LaunchDescriptionEntity


@public("launch.event")
class Event:
    """Base of all events; `name` identifies the kind."""

    name = "launch.Event"


@public("launch.event_handler")
class BaseEventHandler:
    """Base of handlers; subclasses override `handle` and call super()."""

    _origin: FileLine | None = None  # of the action of the launch file that has registered it
    _event_class: type | None = None  # what it matches are instances of it; None: anything
    handle_once: bool = read_only("Whether the handler is unregistered after its first event.")

    def __init__(self, *, matcher: Callable[[Event], bool], handle_once: bool = False) -> None:
        self.__matcher = matcher
        self.__handle_once = handle_once

    @property
    def handler_description(self) -> str:
        """The reaction, for `describe`."""
        return self.__repr__()

    @property
    def matcher_description(self) -> str:
        """The events that match, for `describe`."""
        return self.__repr__()

    def matches(self, event: Event) -> bool:
        return self.__matcher(event)

    def _expects(self, event_class: type) -> None:
        """The matcher takes only events of this class; a subclass may have its own `matches`."""
        if type(self).matches is BaseEventHandler.matches:
            self._event_class = event_class

    def describe(self) -> tuple[str, list[LaunchDescriptionEntity]]:
        """(text, entities that are known before an event)."""
        return (
            f"{type(self).__name__}(matcher='{self.matcher_description}', "
            f"handler='{self.handler_description}', handle_once={self.handle_once})",
            [],
        )

    def handle(self, event: Event, context: LaunchContext) -> Any:
        """Set `context.locals.event`; with `handle_once`, unregister this handler."""
        context.extend_locals({"event": event})
        if self.handle_once:
            context.unregister_event_handler(self)
        return None


@public("launch.event_handler")
class EventHandler(BaseEventHandler):
    """Yields the same entities for each matching event."""

    entities: Any = read_only("One entity, several, or None, as given.")

    def __init__(
        self,
        *,
        matcher: Callable[[Event], bool],
        entities: Any = None,
        handle_once: bool = False,
    ) -> None:
        super().__init__(matcher=matcher, handle_once=handle_once)
        self.__entities = entities
        if not isinstance(entities, Iterable | None):
            launch_session.current().note_use("EventHandler(entities=ENTITY)", caller_origin())

    def describe(self) -> tuple[str, list[LaunchDescriptionEntity]]:
        text, _ = super().describe()
        entities = self.__entities
        if entities is None:
            return (text, [])
        return (text, list(entities) if isinstance(entities, Iterable) else [entities])

    def handle(self, event: Event, context: LaunchContext) -> Any:
        super().handle(event, context)
        return self.entities


class EventHandlers:
    """The registered handlers: the newest first, then those that were appended.

    Every process has three and every timer one, for events that hardly occur, and every action that
    is visited asks who waits for its end. So the handlers for a class of events are kept apart.
    """

    def __init__(self) -> None:
        self._all: deque[BaseEventHandler] = deque()
        self._by_class: dict[type, deque[BaseEventHandler]] = {}

    def __iter__(self) -> Iterator[BaseEventHandler]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def add(self, handler: BaseEventHandler, *, is_last: bool = False) -> None:
        """Put a handler before all others, or behind them."""
        fitting = [some for kind, some in self._by_class.items() if _may_match(handler, kind)]
        for handlers in (self._all, *fitting):
            if is_last:
                handlers.append(handler)
            else:
                handlers.appendleft(handler)

    def remove(self, handler: BaseEventHandler) -> None:
        """Remove a handler; ValueError if it is not among them."""
        self._all.remove(handler)
        for handlers in self._by_class.values():
            if handler in handlers:
                handlers.remove(handler)

    def of(self, event: object) -> tuple[BaseEventHandler, ...]:
        """Those that may match an event, or events of this class, as they are now."""
        # A launch file may emit a class: handlers of Shutdown match that, too.
        kind = event if isinstance(event, type) else event.__class__
        if kind not in self._by_class:
            fitting = deque(handler for handler in self._all if _may_match(handler, kind))
            self._by_class[kind] = fitting
        return tuple(self._by_class[kind])


def _may_match(handler: BaseEventHandler, kind: type) -> bool:
    known = getattr(handler, "_event_class", None)  # none: a launch file's own class
    return known is None or issubclass(kind, known)
