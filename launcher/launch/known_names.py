"""Names of launch configurations that a launch file may read at some time.

The evaluation records the names that are read with the given arguments. What is behind a false
condition, or comes with a later event, is searched for in the objects that the launch file has
created.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from types import CodeType, FunctionType, MethodType, ModuleType

from launcher.base.errors import PackageNotFoundError
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.include import IncludeLaunchDescription
from launcher.language.compat import vocabulary
from launcher.language.conditions import LaunchConfigurationEquals
from launcher.language.configurations import ALL_NAMES, Configurations
from launcher.language.context import LaunchContext
from launcher.language.diagnostics.origin import is_library, is_own_file
from launcher.language.entity import LaunchDescriptionEntity
from launcher.language.events.base import BaseEventHandler
from launcher.language.interpreter.unvisited import is_harmless
from launcher.language.substitution import TextSubstitution, perform_substitutions
from launcher.language.substitutions.configuration import LaunchConfiguration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.launch.plan.plan import Plan

# A timer has the values of the moment at which it began, which uses none of them.
_WITHOUT_NAMES = (str, bytes, int, float, LaunchContext, Configurations, type(None))
_MAX_OBJECTS = 200_000  # the search ends there
_VOCABULARY = ("launch", "launch_ros", "launch_xml", "launch_yaml", "launcher")
_LEAST_PART = 2  # characters of a text that may be a part of a name
_ALL_OF_THEM = {"items", "keys", "values", "copy", "dict", "list", "sorted"}


class KnownNames:
    """What an evaluation has `used` of names, and what may be used later.

    `names` are used as such, `texts` are in functions, which may use them as names.
    `reads_arguments`: the launch file has looked at the words of the command line itself.
    """

    def __init__(
        self,
        used: Iterable[str],
        description: object = None,
        context: LaunchContext | None = None,
        *,
        reads_arguments: bool = False,
    ) -> None:
        self._reads_arguments = reads_arguments
        self._files = _texts_of_files(context) if reads_arguments else []
        self._search = _NameSearch(context)
        if description is not None:
            with vocabulary():  # files that are included under a condition are loaded now
                self._search.look_at(description)
        self.names = frozenset(used) | self._search.names
        self.texts = frozenset(self._search.texts)

    def has(self, name: str) -> bool:
        """Whether something uses the name, as far as that can be seen."""
        if ALL_NAMES in self.names or name in self.names or name in self.texts:
            return True
        word = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)")
        return any(word.search(text) for text in self._files)

    def doubt(self, name: str) -> str | None:
        """Why a name may be used that is not known; None if it certainly is not."""
        if self._reads_arguments:
            return "unless the launch file takes it from sys.argv"
        if self._search.is_open:
            return "unless a part of the launch file uses it that is only known later"
        if any(part in name for part in self._search.parts):
            return "unless a function uses it that is called later"
        return None


def known_names(plan: Plan) -> KnownNames:
    """The names that the dry run has read, and those in parts that it did not reach."""
    return KnownNames(
        plan.known_names, plan.description, plan.context, reads_arguments=plan.reads_arguments
    )


def _texts_of_files(context: LaunchContext | None) -> list[str]:
    """The launch files, one of which takes arguments from the command line."""
    texts = []
    for path in () if context is None else context._includers:
        with contextlib.suppress(OSError), open(path, encoding="utf-8", errors="replace") as file:
            texts.append(file.read())
    return texts


class _NameSearch:
    """The objects that a description and event handlers lead to; `look_at` them.

    `parts` are texts of functions that were not called, of which a name may be made. `is_open`:
    something cannot be looked into yet.
    """

    def __init__(self, context: LaunchContext | None) -> None:
        self._context = LaunchContext() if context is None else context
        self._seen: dict[int, tuple[Any, bool]] = {}  # with the objects, or an id is used again
        self.names: set[str] = set()
        self.texts: set[str] = set()
        self.parts: set[str] = set()
        self.is_open = False

    def look_at(self, description: object) -> None:
        waiting = [(part, False) for part in (description, *self._context._event_handlers)]
        while waiting:
            part, is_called = waiting.pop()
            if isinstance(part, _WITHOUT_NAMES):
                continue
            if isinstance(part, (LaunchDescriptionEntity, BaseEventHandler)):
                is_called = getattr(part, "_was_executed", False)
            known = self._seen.get(id(part))
            if known is not None and (is_called or not known[1]):
                continue
            if len(self._seen) == _MAX_OBJECTS:
                self.is_open = True
                return
            self._seen[id(part)] = (part, is_called)
            self._note(part, is_called)
            with contextlib.suppress(Exception):  # code of the launch file is in some of them
                waiting += [(one, is_called) for one in self._parts_of(part)]

    def _note(self, part: object, is_called: bool) -> None:
        """Names that this object itself uses."""
        if isinstance(part, DeclareLaunchArgument):
            self.names.add(part.name)
        elif isinstance(part, LaunchConfigurationEquals):
            self.names.add(part.launch_configuration_name)
        elif isinstance(part, LaunchConfiguration):
            texts = [sub.text for sub in part.variable_name if isinstance(sub, TextSubstitution)]
            self.names.add("".join(texts))
        elif isinstance(part, FunctionType):
            self._note_function(part, is_called)
        elif isinstance(part, partial):
            self.texts.update(_texts_among([part.args, part.keywords]))

    def _note_function(self, function: FunctionType, is_called: bool) -> None:
        texts = {*_texts_in(function.__code__), *_texts_among(_around(function))}
        self.texts |= texts
        if not is_called and _is_foreign(function):
            used = set(_names_in(function.__code__))
            self.parts |= {text for text in texts if len(text) >= _LEAST_PART}
            self.is_open |= "launch_configurations" in used and bool(used & _ALL_OF_THEM)

    def _parts_of(self, part: object) -> list[Any]:
        if isinstance(part, Mapping):
            return [*part.keys(), *part.values()]
        if isinstance(part, (list, tuple, set, frozenset)):
            return list(part)
        if isinstance(part, MethodType):
            return [part.__self__, part.__func__]
        if isinstance(part, partial):
            return [part.func, part.args, part.keywords]
        if isinstance(part, FunctionType):
            return _around(part)
        if isinstance(part, type):
            return _methods(part)
        if isinstance(part, IncludeLaunchDescription):
            return [*vars(part).values(), *self._included(part)]
        if _is_of_the_vocabulary(type(part)):
            return [*_below(part), *vars(part).values(), *_methods(type(part))]
        return [*vars(part).values(), *_methods(type(part))] if callable(part) else []

    def _included(self, include: IncludeLaunchDescription) -> list[Any]:
        source = include.launch_description_source
        if source._loaded is not None:
            return [source._loaded]
        try:
            if not is_harmless(source._location_parts):
                raise ValueError
            perform_substitutions(self._context, source._location_parts)
        except PackageNotFoundError:
            return []
        except Exception:
            self.is_open = True  # which file it is is only known later
            return []
        return [source._load_early(self._context)]


def _texts_among(parts: Iterable[Any], depth: int = 4) -> Iterator[str]:
    for part in parts if depth else ():
        if isinstance(part, str):
            yield part
        elif isinstance(part, Mapping):
            yield from _texts_among([*part.keys(), *part.values()], depth - 1)
        elif isinstance(part, (list, tuple, set, frozenset)):
            yield from _texts_among(part, depth - 1)


def _below(part: object) -> list[Any]:
    if isinstance(part, BaseEventHandler):
        return list(part.describe()[1])
    if not isinstance(part, LaunchDescriptionEntity):
        return []
    conditional = [entities for _, entities in part.describe_conditional_sub_entities()]
    return [*part.describe_sub_entities(), *conditional]


# ---- code of the launch file


def _is_foreign(function: object) -> bool:
    """Whether it is a function, and not ours."""
    return isinstance(function, FunctionType) and not is_own_file(function.__code__.co_filename)


def _is_of_a_user(function: Any) -> bool:
    """Whether it is a function that is not of an installed package, either."""
    return _is_foreign(function) and not is_library(function.__code__.co_filename)


def _methods(cls: type) -> list[Any]:
    return [one for base in cls.__mro__ for one in vars(base).values() if _is_foreign(one)]


def _around(function: FunctionType) -> list[Any]:
    """What a function of the user refers to: variables around it, defaults, globals by name."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    if not _is_of_a_user(function):
        return cells
    names = list(_names_in(function.__code__))
    found = [function.__globals__.get(name) for name in names]
    for module in [one for one in found if isinstance(one, ModuleType)]:
        found += [vars(module).get(name) for name in names]
    defaults = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
    return [*cells, *defaults, *filter(_may_have_names, found)]


def _may_have_names(part: object) -> bool:
    if isinstance(part, type):
        return any(map(_is_of_a_user, _methods(part)))
    return isinstance(part, (str, list, tuple, set, dict, partial)) or _is_of_a_user(part)


def _texts_in(code: CodeType) -> Iterator[str]:
    """Every string constant of a function, since it may be a name that it reads."""
    for constant in code.co_consts:
        if isinstance(constant, str):
            yield constant
        elif isinstance(constant, (tuple, frozenset)):
            yield from (item for item in constant if isinstance(item, str))
        elif isinstance(constant, CodeType):
            yield from _texts_in(constant)


def _names_in(code: CodeType) -> Iterator[str]:
    """Every global and attribute that a function names."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names_in(constant)


def _is_of_the_vocabulary(cls: type) -> bool:
    return any(base.__module__.partition(".")[0] in _VOCABULARY for base in cls.__mro__)
