"""Records the visited entities as a tree, for plans."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from launcher.base.model.record import Record
from launcher.language.actions.event_actions import EmitEvent
from launcher.language.conditions import Condition
from launcher.language.configurations import Configurations
from launcher.language.context import LaunchContext
from launcher.language.diagnostics.origin import FileLine
from launcher.language.diagnostics.truth_values import configurations_in

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class ConfigurationSetting(Record):
    """A launch configuration that got a value; `origin` is None for the command line."""

    name: str
    value: object
    origin: FileLine | None


class Visit:
    """One visit of an entity and, below it, the visits of what it yielded.

    `depth` counts from 1; `stamp`: the time; `event`: the cause of a visit without parent;
    `skipped`: the condition was false; `read`: values of the launch configurations that the
    condition reads, `known`: of those that the entity itself holds; `settings`, `logs`,
    `processes`: launch configurations set, messages printed and numbers of processes started by
    this visit itself.
    """

    def __init__(self, entity: Any, parent: Visit | None, stamp: Any, event: Any) -> None:
        self.entity = entity
        self.parent = parent
        self.depth: int = 1 if parent is None else parent.depth + 1
        self.stamp = stamp
        self.event = event
        self.children: list[Visit] = []
        self.read: dict[str, Any] = {}
        self.known: dict[str, Any] = {}
        self.settings: list[ConfigurationSetting] = []
        self.logs: list[str] = []
        self.processes: list[int] = []
        self.skipped = False

    def walk(self) -> Iterator[Visit]:
        """This visit and all below it, in order."""
        waiting = [self]
        while waiting:
            visit = waiting.pop()
            yield visit
            waiting += reversed(visit.children)


class Trace:
    """Collects visits; `stamp` returns the time of each. `event` is the cause of the last ones."""

    def __init__(self, context: LaunchContext, stamp: Callable[[], Any]) -> None:
        self._context = context
        self._stamp = stamp
        self._path: list[Visit] = []
        self._current: Visit | None = None
        self._of_entity: dict[int, Visit] = {}
        self._of_event: dict[int, Visit] = {}
        self.roots: list[Visit] = []
        self.event: Any = None

    def visiting(self, entity: Any, depth: int) -> None:
        """A visit begins, `depth` levels below an event (from 1)."""
        del self._path[depth - 1 :]
        parent = self._path[-1] if self._path else None
        event = None
        if parent is None:
            event = self.event = self._context.get_locals_as_dict().get("event")
        visit = Visit(entity, parent, self._stamp(), event)
        (self.roots if parent is None else parent.children).append(visit)
        self._path.append(visit)
        self._current = visit
        self._of_entity[id(entity)] = visit
        if isinstance(entity, EmitEvent):
            self._of_event[id(entity.event)] = visit
        condition = getattr(entity, "condition", None)
        if isinstance(condition, Condition):
            visit.read = self._values(condition)
        visit.known = self._values([*_flat(vars(entity).values())])
        if hasattr(entity, "default_value"):
            self._note_argument(visit)

    def skipped(self, action: Any) -> None:
        """The condition of the action being visited was false."""
        if self._current is not None and self._current.entity is action:
            self._current.skipped = True

    def configured(self, name: str, value: object, origin: FileLine | None) -> None:
        """A launch configuration was set."""
        if self._current is not None:
            self._current.settings.append(ConfigurationSetting(name, value, origin))

    def logged(self, text: str) -> None:
        """The launch file printed a message."""
        if self._current is not None:
            self._current.logs.append(text)

    def started(self, action: Any, process: int) -> None:
        """An action that was visited started a process."""
        visit = self.visit_of(action)
        if visit is not None:
            visit.processes.append(process)

    def visit_of(self, entity: Any) -> Visit | None:
        """The last visit of an entity."""
        return self._of_entity.get(id(entity))

    def emission_of(self, event: Any) -> Visit | None:
        """The last visit of the action that emits this event."""
        return self._of_event.get(id(event))

    def _note_argument(self, visit: Visit) -> None:
        """Record where the value of an argument was set, if it has one already."""
        configurations = self._context.launch_configurations
        name = visit.entity.name
        value = configurations.peek(name)
        if value is not None:
            visit.settings.append(ConfigurationSetting(name, value, configurations.origin_of(name)))

    def _values(self, reader: object) -> dict[str, Any]:
        names = dict.fromkeys(configurations_in(reader))
        return {name: self._context.launch_configurations.peek(name) for name in names}


def _flat(values: Iterable[Any]) -> Iterator[Any]:
    """The values, and the keys and values of dictionaries among them.

    Without the configurations that a timer keeps, of which it uses none.
    """
    for value in values:
        if isinstance(value, Configurations):
            continue
        if isinstance(value, dict):
            yield from value
            yield from value.values()
        else:
            yield value
