"""Which groups and included files are around a process, and what conditions have switched off.

Also around what comes later: the actions of timers and the entities of event handlers. What a
function of an event handler returns is in no group.
"""

from __future__ import annotations

from collections.abc import Iterable

from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec, Scope
from launcher.language.actions.event_actions import RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.process import ExecuteLocal
from launcher.language.actions.timer import TimerAction
from launcher.language.interpreter.unvisited import Search, described_scope, handler_entities
from launcher.language.ros.scope import PushROSNamespace

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

NAMESPACE = "ros_namespace"  # the launch configuration


class VisitLevel:
    """A visit below others; `namespace` is that of a group that pushes one."""

    __slots__ = ("entity", "namespace", "parent")

    def __init__(self, parent: VisitLevel | None, entity: object) -> None:
        self.parent = parent
        self.entity = entity
        self.namespace: str | None = None

    @property
    def scope(self) -> Scope | None:
        """What it is, if it is a group or an include.

        Evaluated late: the path of an include is known only when it was loaded.
        """
        scope = described_scope(self.entity)
        return scope and replace(scope, namespace=self.namespace)

    @property
    def scopes(self) -> tuple[Scope, ...]:
        """Those of the parents and its own, the outermost first."""
        found: list[Scope] = []
        level: VisitLevel | None = self
        while level is not None:
            found += filter(None, [level.scope])
            level = level.parent
        return tuple(reversed(found))


class Scopes:
    """Follows the visits of a run; `off` are processes that a false condition has kept away."""

    def __init__(self, context: LaunchContext) -> None:
        self._context = context
        self._path: list[VisitLevel] = []
        self._later: dict[int, tuple[Any, VisitLevel]] = {}  # by id of an entity that comes later
        self._of: dict[int, VisitLevel] = {}  # by id of an action
        self._pushing: tuple[VisitLevel, Any] | None = None  # the group, and its namespace before
        self.off: list[ProcessSpec] = []
        self.is_off_complete = True

    def visiting(self, entity: object, depth: int) -> None:
        """A visit begins, `depth` levels below an event (from 1)."""
        self._note_namespace()
        del self._path[depth - 1 :]
        known = self._later.get(id(entity))
        parent = known[1] if known else self._path[-1] if self._path else None
        level = VisitLevel(parent, entity)
        self._path.append(level)
        if isinstance(entity, ExecuteLocal):
            self._of[id(entity)] = level
        for one in _deferred(entity):
            self._later[id(one)] = (one, level)
        if isinstance(entity, PushROSNamespace):
            self._begin_push(level)

    def around(self, action: Any) -> tuple[Scope, ...]:
        """The scopes of an action that was visited."""
        self._note_namespace()
        known = self._of.get(id(action))
        return known.scopes if known else ()

    def skipped(self, action: Any) -> None:
        """The condition of the action being visited was false."""
        parent = self._path[-1].parent if self._path else None
        outer = () if parent is None else parent.scopes
        search = Search(self._context)
        self.off += [one.spec for one in search.processes([action], outer)]
        self.is_off_complete &= search.is_complete

    def around_later(self, entity: object) -> tuple[Scope, ...]:
        """The scopes of an entity of a timer or an event handler."""
        known = self._later.get(id(entity))
        return known[1].scopes if known else ()

    def _begin_push(self, level: VisitLevel | None) -> None:
        while level is not None and not isinstance(level.entity, (GroupAction, TimerAction)):
            level = level.parent
        if level is not None and isinstance(level.entity, GroupAction):
            self._pushing = (level, self._context.launch_configurations.peek(NAMESPACE))

    def _note_namespace(self) -> None:
        if self._pushing is None:
            return
        level, before = self._pushing
        self._pushing = None
        namespace = self._context.launch_configurations.peek(NAMESPACE)
        if namespace != before:
            level.namespace = namespace


def _deferred(entity: Any) -> Iterable[Any]:
    """The entities that come later, outside of the visit of this one."""
    if isinstance(entity, TimerAction):
        return list(entity.actions)
    if isinstance(entity, RegisterEventHandler):
        return handler_entities(entity.event_handler)
    return entity.get_sub_entities() if isinstance(entity, ExecuteLocal) else ()
