"""Sentences for values of a wrong type: what was given, what it takes, how to write it."""

from __future__ import annotations

import ast
import re

from launcher.base.model.record import Record
from launcher.language.diagnostics import keywords, not_texts, source_code, wrong_objects
from launcher.language.diagnostics.origin import FileLine, is_own_file
from launcher.language.entity import LaunchDescriptionEntity

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_NOT_EXPECTED = re.compile(
    r"^(?:'(?P<caller>\w+)(?:\(\))?' e|E)xpected '(?P<name>\w+)' to be one of \[(?P<types>.*)\], "
    r"but got '(?P<value>.*)' of type '<class '(?P<given>[\w.]+)'>'$",
    re.DOTALL,
)
_NOT_ITERABLE = re.compile(
    r"^(?:'(?=\w+' object is not iterable$)|Value after \* must be an iterable, not )(\w+)"
)
_REMAP_LENGTH = re.compile(r"^remap_rule must be a tuple of length 2")
_NOT_NORMAL = re.compile(r"^Failed to normalize given item of type '<class '(?:[\w<>]+\.)*(\w+)'>'")
_POSITIONAL = re.compile(r"^(?:\w+\.)*?(\w+)\.__init__\(\) takes .*positional arguments? but ")
# How to write a value of these types as a text.
_TEXT_OF = {
    "bool": "'true'",
    "float": "'2.5'",
    "int": "'3'",
    "NoneType": "''",
    "PurePosixPath": "str(...)",
    "bytes": "'...'",
}
_MAX_SHOWN = 60  # characters of a value in a hint
_TEXT_TYPES = ("Substitution", "Iterable")  # what a text may also be


class Sentence(Record):
    """A message and a hint for an error; `place` and `word` say where the caret is."""

    message: str
    hint: str | None
    word: str | None = None
    place: FileLine | None = None


def sentence(error: BaseException, place: FileLine | None) -> Sentence | None:
    """The sentence for a classic mistake; None if it is none."""
    text = str(error)
    found = _NOT_EXPECTED.match(text) if isinstance(error, TypeError) else None
    if found is not None:
        return _wrong_type(found, place)
    as_text = wrong_objects.sentence(error, place) or not_texts.sentence(error, place)
    if as_text is not None:
        message, hint, word = as_text
        return Sentence(message=message, hint=hint, word=word)
    if not isinstance(error, TypeError):
        return None
    misspelt = keywords.sentence(error, place)
    if misspelt is not None:
        return Sentence(*misspelt)
    if _REMAP_LENGTH.match(text):
        return _remappings("each entry of remappings is a pair of names", place)
    found = _POSITIONAL.match(text)
    if found is not None:
        return _positional(found[1], place)
    found = _NOT_NORMAL.match(text)
    if found is not None and found[1] in ("list", "tuple"):
        message = f"a {found[1]} among texts and substitutions"
        return Sentence(message=message, hint="write its items without the inner brackets")
    found = found or _NOT_ITERABLE.match(text)
    if found is None:
        return None
    if found[1] in _TEXT_OF or _is_path_like(found[1], error):
        return _no_text(found[1], place, error) if _is_in_launcher(error) else None
    return _single(found[1], place)


def _remappings(message: str, place: FileLine | None) -> Sentence:
    hint, at = "write remappings=[('from', 'to')]", None
    for node in () if place is None else source_code.nodes_at(place):
        for one in node.keywords if isinstance(node, ast.Call) else ():
            if one.arg == "remappings" and place is not None:
                at = FileLine(place.path, one.lineno)
                if isinstance(one.value, ast.Tuple) and len(one.value.elts) == 2:
                    hint = f"write remappings=[{ast.unparse(one.value)}]"
    return Sentence(message=message, hint=hint, word="remappings", place=at)


# ---- a value of a wrong type


def _wrong_type(found: re.Match[str], place: FileLine | None) -> Sentence:
    caller, name, value = found["caller"], found["name"], found["value"]
    given = found["given"].rpartition(".")[2]
    if name == "remap_rule":
        message = f"each entry of remappings is a pair of names in parentheses, not a {given}"
        return _remappings(message, place)
    whose = "" if caller is None else f" of {caller}"
    types = [one.rpartition(".")[2] for one in re.findall(r"<class '([\w.]+)'>", found["types"])]
    at = source_code.keyword_place(place, caller, name) if place and caller else None
    return Sentence(
        message=f"{name}{whose} takes {_alternatives(types)}, not {_with_article(given)}",
        hint=_written(types, given, value, place, caller, name),
        word=name,
        place=at,
    )


def _alternatives(types: Sequence[str]) -> str:
    words = {"str": "text", "Iterable": "list", "NoneType": "None", "dict": "dictionary"}
    named = [words.get(one, one) for one in types]
    if set(_TEXT_TYPES) <= set(types):
        named = [*(one for one in named if one not in ("Substitution", "list")), "Substitution"]
    named.sort(key=lambda one: one not in ("float", "int"))
    *others, last = map(_with_article, dict.fromkeys(named))
    return f"{', '.join(others)} or {last}" if others else last


def _with_article(noun: str) -> str:
    if noun in ("None", "bytes"):
        return noun
    return f"{'an' if noun[0] in 'aeiouAEIO' else 'a'} {noun}"


def _written(
    types: Sequence[str],
    given: str,
    value: str,
    place: FileLine | None,
    caller: str | None,
    name: str,
) -> str | None:
    """How the value should be written: `3.0` for 3, `[{...}]` for {...}; None if unknown."""
    if caller is None:
        return None
    if given == "int" and "float" in types:
        return f"write {name}={value}.0"
    code = None
    call = source_code.call_at(place, caller) if place else None
    for one in () if call is None else call.keywords:
        if one.arg == name:
            code = ast.unparse(one.value)
    if "list" in types or "Iterable" in types:
        return f"write {name}=[{code if code and len(code) <= _MAX_SHOWN else '...'}]"
    return None


# ---- a single action instead of a list


def _single(name: str, place: FileLine | None) -> Sentence | None:
    if not name[0].isupper():
        return None
    for node in () if place is None else source_code.nodes_at(place):
        if isinstance(node, ast.Call) and node.args:
            function, first = ast.unparse(node.func), node.args[0]
            if isinstance(first, ast.Call) and ast.unparse(first.func).endswith(name):
                called = function.rpartition(".")[2]
                message = f"{called} takes a list of actions, not a single {name}"
                return Sentence(message=message, hint=f"write {called}([{name}(...)])", word=name)
    message = f"a list is expected here, not a single {name}"
    return Sentence(message=message, hint=f"write a list, as in [{name}(...)]", word=name)


# ---- a number, a truth value or a path instead of a text


def _is_in_launcher(error: BaseException) -> bool:
    """Whether the launcher refused the value, and not code of the launch file."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and is_own_file(trace.tb_frame.f_code.co_filename)


def _no_text(kind: str, place: FileLine | None, error: BaseException) -> Sentence:
    compared = wrong_objects.comparison_at(place) if kind == "bool" else None
    if compared is not None:
        message = "a substitution is compared with a text, and is never equal to it"
        return Sentence(message=message, hint=f"write {compared[0]}", word=compared[1])
    message = f"{_with_article(kind)} where a text or a substitution is expected"
    values = [] if place is None else list(_values_of(kind, place))
    if len(values) != 1 or place is None:
        text = _given_text(kind, error) or _TEXT_OF.get(kind, "os.fspath(...)")
        hint = f"write it as a text, as in {text}"
        return Sentence(message=message, hint=hint)
    (node,) = values
    code = ast.unparse(node)
    text = repr(code.lower() if kind == "bool" else code)
    if kind == "PurePosixPath":
        text = f"str({code})"
    elif kind not in _TEXT_OF:
        text = f"os.fspath({code})"
    elif isinstance(node, ast.Constant) and isinstance(node.value, bytes):
        text = repr(node.value.decode(errors="replace"))
    at = FileLine(place.path, node.lineno)
    return Sentence(message=message, hint=f"write {text}", word=code, place=at)


def _is_path_like(kind: str, error: BaseException) -> bool:
    return any(hasattr(type(one), "__fspath__") for one in _refused(kind, error))


def _given_text(kind: str, error: BaseException) -> str | None:
    """The value of this type that the launcher refused, as a text."""
    found = _refused(kind, error)
    return repr(str(found[0])) if kind in ("float", "int") and len(found) == 1 else None


def _refused(kind: str, error: BaseException) -> list[object]:
    """The values of this type where the error was raised."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    values = () if trace is None else trace.tb_frame.f_locals.values()
    return [one for one in values if type(one).__name__ == kind]


def _values_of(kind: str, place: FileLine) -> Iterator[ast.expr]:
    """Values of this type in the calls that begin in the line, without those in dictionaries."""
    calls = (one for one in source_code.nodes_at(place) if isinstance(one, ast.Call))
    call = next((one for one in calls if one.lineno == place.line), None)
    waiting: list[ast.AST] = [] if call is None else [call]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Dict):
            continue
        made = ast.unparse(node.func).rpartition(".")[2] if isinstance(node, ast.Call) else ""
        is_path = made.endswith("Path") and kind == "PurePosixPath"
        is_value = isinstance(node, ast.Constant) and type(node.value).__name__ == kind
        if isinstance(node, ast.expr) and (is_value or is_path or made == kind):
            yield node
        else:
            waiting += ast.iter_child_nodes(node)


# ---- positional arguments


def _positional(name: str, place: FileLine | None) -> Sentence:
    message = f"{name} takes its arguments by name"
    call = None if place is None else source_code.call_at(place, name)
    if call is None:
        return Sentence(message=message, hint=f"write {name}(NAME=VALUE)", word=name)
    given = [ast.unparse(one) for one in call.args]
    if name == "LaunchDescription" or name == "GroupAction":
        message = f"{name} takes one list of actions"
        return Sentence(message=message, hint=_if_short(f"{name}([{', '.join(given)}])"), word=name)
    names = list(_keywords_of(name))[: len(given)]
    written = ", ".join(f"{key}={value}" for key, value in zip(names, given, strict=False))
    hint = _if_short(f"{name}({written or 'NAME=VALUE'})")
    return Sentence(message=message, hint=hint, word=name)


def _if_short(code: str) -> str:
    return f"write {code}" if len(code) <= 2 * _MAX_SHOWN else f"write {code[:_MAX_SHOWN]}..."


def _keywords_of(name: str) -> Iterator[str]:
    """Keyword arguments of the class of actions of this name, the positional ones first."""
    import inspect

    waiting: list[type] = [LaunchDescriptionEntity]
    while waiting:
        cls = waiting.pop()
        waiting += cls.__subclasses__()
        if cls.__name__ == name:
            for key, one in inspect.signature(cls).parameters.items():
                if one.kind in (one.KEYWORD_ONLY, one.POSITIONAL_OR_KEYWORD):
                    yield key
            return
