"""What a run may start after its first moment, as far as that is known then.

The first moment is the visit of the static part. What follows is in timers and event handlers:
their entities are looked into, and nothing of them is executed.
"""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.model.events import LoadRequest
from launcher.base.model.record import Record
from launcher.base.model.spec import Scope
from launcher.language.actions.timer import RosTimer
from launcher.language.events.handlers import OnIncludeLaunchDescription, TargetedHandler
from launcher.language.interpreter.interpreter import Interpreter
from launcher.language.interpreter.unvisited import EventTime, Search, Unvisited, handler_entities

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_OF_EVERY_RUN = (OnIncludeLaunchDescription, TargetedHandler)


class Later(Record):
    """`is_complete`: nothing else can be started."""

    processes: tuple[Unvisited, ...] = ()
    loads: tuple[LoadRequest, ...] = ()
    is_complete: bool = True


def later(interpreter: Interpreter) -> Later:
    """What comes after the first moment, which has just been evaluated."""
    host, context = interpreter.host, interpreter.context
    search = Search(context)
    found = [*_of_timers(interpreter, search), *_of_handlers(interpreter, search)]
    is_complete = (
        search.is_complete
        and all(timer.action is not None for timer in host.timers.values())
        and all(future.done() for future in context._completion_futures)
        and all(one.spec.label for one in found)
    )
    return Later(tuple(found), tuple(search.loads), is_complete)


def _of_timers(interpreter: Interpreter, search: Search) -> Iterator[Unvisited]:
    for timer in interpreter.host.timers.values():
        if timer.action is None:
            continue
        entities = list(timer.action.actions)
        delay_s = None if isinstance(timer.action, RosTimer) else timer.delay_s
        scopes = _scopes(interpreter, entities)
        with search.among(timer.action._configurations):
            yield from search.processes(entities, scopes, EventTime(time_s=delay_s))


def _of_handlers(interpreter: Interpreter, search: Search) -> Iterator[Unvisited]:
    for handler in interpreter.context._event_handlers:
        if not isinstance(handler, _OF_EVERY_RUN):
            scopes = _scopes(interpreter, handler_entities(handler))
            yield from search.of_event(handler, scopes)


def _scopes(interpreter: Interpreter, entities: list[Any]) -> tuple[Scope, ...]:
    known = interpreter.host.scopes
    return known.around_later(entities[0]) if known is not None and entities else ()
