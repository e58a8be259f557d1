"""LaunchDescription: the entities of one launch file, in order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from launcher.language.class_tools import is_iterable
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.naming import public, read_only
from launcher.language.utilities import remember_place

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.action import Action
    from launcher.language.actions.arguments import DeclareLaunchArgument
    from launcher.language.context import LaunchContext
    from launcher.language.diagnostics.origin import FileLine


# Methods that say which entities there are; the former call the latter.
_SUB_ENTITIES = ("describe_sub_entities", "get_sub_entities")
_CONDITIONAL = ("describe_conditional_sub_entities", "get_sub_entities")
_MAX_SELF_INCLUDES = 6  # levels of a file that includes itself, searched for arguments


@public("launch.launch_description")
class LaunchDescription(LaunchDescriptionEntity):
    """The result of `generate_launch_description()`."""

    entities: list[LaunchDescriptionEntity] = read_only()
    deprecated_reason: str | None = read_only()

    def __init__(
        self,
        initial_entities: Iterable[LaunchDescriptionEntity] | None = None,
        *,
        deprecated_reason: str | None = None,
    ) -> None:
        self.__entities = [] if initial_entities is None else list(initial_entities)
        self.__deprecated_reason = deprecated_reason

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Yield the entities; warn if the description is deprecated."""
        if self.__deprecated_reason is not None:
            path = context.get_locals_as_dict().get("current_launch_file_path")
            what = "deprecated launch description: "
            if path is not None:
                what = f"launch file [{path}] is deprecated: "
            host = getattr(context, "_host", None)  # a context of somebody's test has none
            if host is not None:
                host.log("launch", "WARNING", what + self.__deprecated_reason)
        return self.__entities

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        return self.__entities

    def get_launch_arguments(
        self, conditional_inclusion: bool = False
    ) -> list[DeclareLaunchArgument]:
        """Declared arguments, also those of files that can be included without a context."""
        pairs = self.get_launch_arguments_with_include_launch_description_actions(
            conditional_inclusion
        )
        return [argument for argument, _ in pairs]

    def get_launch_arguments_with_include_launch_description_actions(
        self, conditional_inclusion: bool = False
    ) -> list[tuple[DeclareLaunchArgument, list[Any] | None]]:
        """(argument, the includes that lead to it); the first declaration of a name counts."""
        return self._declarations(conditional=conditional_inclusion, loads=True)

    def _declarations(
        self, *, conditional: bool = False, loads: bool
    ) -> list[tuple[DeclareLaunchArgument, list[Any] | None]]:
        """As above; without `loads`, of files that have been loaded already."""
        found = _ArgumentSearch(loads=loads)
        found.search(self, self.entities, conditional=conditional, includes=None)
        return list(found.found.values())

    def add_entity(self, entity: LaunchDescriptionEntity) -> None:
        self.__entities.append(entity)

    def add_action(self, action: Action) -> None:
        self.add_entity(action)

    @property
    def deprecated(self) -> bool:
        return self.__deprecated_reason is not None


class _ArgumentSearch:
    """Collects declarations in the order of the description, each name once.

    Without `loads` it does not enter includes whose file was not loaded yet.
    """

    def __init__(self, *, loads: bool) -> None:
        self._loads = loads
        self.found: dict[str, tuple[DeclareLaunchArgument, list[Any] | None]] = {}
        self._enclosing: list[FileLine] = []  # of the descriptions being searched

    def search(
        self,
        holder: LaunchDescriptionEntity,
        entities: Iterable[Any],
        *,
        conditional: bool,
        includes: list[Any] | None,
    ) -> None:
        for entity in entities:
            if isinstance(entity, LaunchDescription):
                self._search_description(entity, includes)
                continue
            if not hasattr(type(entity), "describe_sub_entities"):
                # Imported only for an error.
                from launcher.language.diagnostics.bad_entries import wrong_entry

                raise wrong_entry(entity, holder, entities)
            # By an attribute, so that the classes need not be imported.
            meaning = getattr(entity, "_to_arguments", "")
            if meaning == "resets":
                return
            if meaning == "declares":
                self._add(entity, conditional, includes)
            below = includes
            if meaning == "includes" and not self._enters(entity):
                continue
            if meaning == "includes":
                # One list for all nested includes of a branch, as in ROS 2.
                below = [] if includes is None else includes
                below.append(entity)
            try:
                known = entity.describe_sub_entities()
            except Exception as error:
                remember_place(error, entity)
                raise
            if not is_iterable(known):
                raise _wrong_return(entity, _SUB_ENTITIES, known, "a list of entities")
            self.search(entity, known, conditional=False, includes=below)
            for conditionals in _conditionals(entity):
                self.search(entity, conditionals, conditional=True, includes=below)

    def _enters(self, include: Any) -> bool:
        return self._loads or include.launch_description_source._loaded is not None

    def _search_description(
        self, description: LaunchDescription, includes: list[Any] | None
    ) -> None:
        # A file that includes itself would be searched endlessly.
        origin = description._origin
        if origin is not None and self._enclosing.count(origin) > _MAX_SELF_INCLUDES:
            return
        known = [] if origin is None else [origin]
        self._enclosing += known
        self.search(description, description.entities, conditional=False, includes=includes)
        del self._enclosing[len(self._enclosing) - len(known) :]

    def _add(
        self, argument: DeclareLaunchArgument, conditional: bool, includes: list[Any] | None
    ) -> None:
        if argument.name in self.found:
            return
        argument._conditionally_included = conditional or argument.condition is not None
        self.found[argument.name] = (argument, includes)


def _conditionals(entity: Any) -> list[Any]:
    """The entities of each condition that a visit may yield later."""
    described = entity.describe_conditional_sub_entities()
    try:
        found = [entities for _, entities in described]
    except (TypeError, ValueError):
        expected = "a list of (text, entities) pairs"
        raise _wrong_return(entity, _CONDITIONAL[:1], described, expected) from None
    for entities in found:
        if not is_iterable(entities):
            raise _wrong_return(entity, _CONDITIONAL, entities, "a list of entities")
    return found


def _wrong_return(entity: object, names: Sequence[str], value: object, expected: str) -> Exception:
    # Imported only for an error.
    from launcher.language.diagnostics.wrong_returns import wrong_return

    return wrong_return(entity, names, value, expected)
