"""`launch.utilities`: flattening and visiting of entities."""

from __future__ import annotations

from launcher.language.class_tools import is_iterable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.entity import LaunchDescriptionEntity


def get_signal_name(signal_number: int) -> str:
    """The name of a signal, like SIGINT."""
    import signal

    return signal.Signals(signal_number).name


def normalize_to_list_of_entities(entities: Any) -> list[LaunchDescriptionEntity]:
    """Entities, nested to any depth in iterables, as one list."""
    flat: list[LaunchDescriptionEntity] = []
    for entity in entities:
        if is_iterable(entity):
            flat.extend(normalize_to_list_of_entities(entity))
        else:
            flat.append(entity)
    return flat


def visit_all_entities_and_collect_futures(
    entity: LaunchDescriptionEntity, context: LaunchContext
) -> list[tuple[LaunchDescriptionEntity, Any]]:
    """Visit an entity and, depth first, all that it yields; (entity, future) of unfinished ones.

    In the order of the visits.
    """
    pairs: list[tuple[LaunchDescriptionEntity, Any]] = []
    context._host.visiting(entity)
    try:
        sub_entities = entity.visit(context)
        future = entity.get_asyncio_future()
        if future is not None:
            pairs.append((entity, future))
        if sub_entities is not None:
            _check_is_list(entity, sub_entities)
            for sub_entity in sub_entities:
                if not hasattr(type(sub_entity), "visit"):
                    raise _wrong_entry(entity, sub_entity, sub_entities)
                pairs += visit_all_entities_and_collect_futures(sub_entity, context)
    except Exception as error:
        remember_place(error, entity)
        raise
    finally:
        context._host.visited()
    return pairs


def _check_is_list(entity: LaunchDescriptionEntity, sub_entities: object) -> None:
    if is_iterable(sub_entities) and not (isinstance(sub_entities, str) and sub_entities):
        return
    if hasattr(type(sub_entities), "__getitem__") and not isinstance(sub_entities, str):
        return  # iterable by the old protocol
    # Imported only for an error.
    from launcher.language.diagnostics.bad_entries import not_a_list

    raise not_a_list(sub_entities, entity)


def _wrong_entry(entity: LaunchDescriptionEntity, item: object, items: object) -> Exception:
    from launcher.language.diagnostics.bad_entries import wrong_entry

    return wrong_entry(item, entity, items)


def remember_place(error: Exception, entity: object) -> None:
    """Attach the place of the innermost entity to an error, for `faults.explain`."""
    # Imported only for an error.
    from launcher.language.diagnostics.error_details import details

    if details(error).entity is None:
        details(error).entity = entity


def create_future(loop: Any) -> Any:
    """A future of the loop; with None, of the running loop or that of the thread."""
    return (_loop() if loop is None else loop).create_future()


def _loop() -> Any:
    import asyncio
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # no loop yet
        try:
            return asyncio.get_event_loop()
        except RuntimeError:  # a thread without a loop
            loop = asyncio.new_event_loop()
            asyncio.set_event_loop(loop)
            return loop
