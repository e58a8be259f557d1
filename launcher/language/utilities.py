"""Utilities of the language: normalising what users pass, performing it, walking entities."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from launcher.language.substitution import Substitution

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.entity import LaunchDescriptionEntity

SomeSubstitutionsType_types_tuple = (str, Substitution, Iterable)


def is_iterable(obj: Any) -> bool:
    """What `isinstance(obj, Iterable)` says, which takes its time for each class that is new."""
    return getattr(type(obj), "__iter__", None) is not None


def is_a(obj: Any, entity_type: type) -> bool:
    """Whether `obj` is an instance of exactly this type, by name of module and class."""
    return isinstance(obj, entity_type)


def is_a_subclass(obj: Any, entity_type: type) -> bool:
    """Whether `obj` is an instance of the type, or is a subclass of it."""
    if isinstance(obj, entity_type):
        return True
    return isinstance(obj, type) and issubclass(obj, entity_type)


def isclassinstance(obj: Any) -> bool:
    """Whether `obj` is an instance of a class, not a class itself."""
    return not isinstance(obj, type)


def get_signal_name(signal_number: int) -> str:
    """The name of a signal, like SIGINT."""
    import signal

    return signal.Signals(signal_number).name


def ensure_argument_type(
    argument: Any, types: Any, argument_name: str, caller: str | None = None
) -> None:
    """TypeError unless `argument` is an instance of one of `types` or a subclass of one."""
    allowed = list(types) if is_iterable(types) else [types]
    if any(is_a_subclass(argument, one) for one in allowed):
        return
    who = "Expected" if caller is None else f"'{caller}' expected"
    raise TypeError(
        f"{who} '{argument_name}' to be one of {allowed}, "
        f"but got '{argument}' of type '{type(argument)}'"
    )


def normalize_to_list_of_substitutions(subs: Any) -> list[Substitution]:
    """One text, one substitution or several of them as a list of substitutions."""
    if isinstance(subs, str):
        return [_as_substitution(subs)]
    if is_a_subclass(subs, Substitution):
        return [subs]
    return [_as_substitution(item) for item in subs]


def _as_substitution(item: Any) -> Substitution:
    from launcher.language.substitutions.text import TextSubstitution

    if isinstance(item, str):
        return TextSubstitution(text=item)
    if is_a_subclass(item, Substitution):
        assert isinstance(item, Substitution)
        return item
    raise TypeError(
        f"Failed to normalize given item of type '{type(item)}', when only "
        f"'str' or 'launch.Substitution' were expected."
    )


def perform_substitutions(context: LaunchContext, subs: Any) -> str:
    """The texts of the substitutions, joined."""
    return "".join([context.perform_substitution(sub) for sub in subs])


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
    """Visit an entity and, depth first, all that it yields; (entity, future) of what goes on."""
    pairs: list[tuple[LaunchDescriptionEntity, Any]] = []
    context._host.visiting(entity)
    try:
        sub_entities = entity.visit(context)
        if sub_entities is not None:
            _check_several(entity, sub_entities)
            for sub_entity in sub_entities:
                if not hasattr(type(sub_entity), "visit"):
                    raise _wrong_entry(entity, sub_entity, sub_entities)
                pairs += visit_all_entities_and_collect_futures(sub_entity, context)
    except Exception as error:
        remember_place(error, entity)
        raise
    finally:
        context._host.visited()
    future = entity.get_asyncio_future()
    if future is not None:
        pairs.append((entity, future))
    return pairs


def _check_several(entity: LaunchDescriptionEntity, sub_entities: Any) -> None:
    if is_iterable(sub_entities) and not (isinstance(sub_entities, str) and sub_entities):
        return
    if hasattr(type(sub_entities), "__getitem__") and not isinstance(sub_entities, str):
        return  # the old way to be iterable
    from launcher.language.entries import not_several  # most launch files have none

    raise not_several(sub_entities, entity)


def _wrong_entry(entity: LaunchDescriptionEntity, item: Any, items: Any) -> Exception:
    from launcher.language.entries import wrong_entry

    return wrong_entry(item, entity, items)


def remember_place(error: Exception, entity: Any) -> None:
    """Let an error know the innermost entity that it came out of, for the message."""
    if not hasattr(error, "_launcher_origin"):
        error._launcher_origin = getattr(entity, "_origin", None)  # type: ignore[attr-defined]


def create_future(loop: Any) -> Any:
    """A future of the loop, or one that needs no loop if there is none."""
    from launcher.language.future import Future

    return Future() if loop is None else loop.create_future()


def class_tuple_to_type_hint(types: Sequence[Any]) -> Any:
    """`Union` of the types."""
    from typing import Union

    return Union[tuple(types)]
